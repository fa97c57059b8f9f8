"""Looks at a live graph and talks to it in the words of ros2cli; `heli topic|node|param|service` become it.

python -m heli_flight.nodes.graph_tool '{"word": "topic", "verb": "list", "show_types": false}'
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable
from importlib import import_module
from time import perf_counter
from typing import Any

from heli_flight.nodes.live_graph import LiveGraph  # first: it takes the signals before rclpy does

# isort: split
import yaml
from rclpy.action import get_action_client_names_and_types_by_node, get_action_server_names_and_types_by_node

from heli_common.errors import EXIT_BAD_INPUT, EXIT_FLOWN, EXIT_INTERRUPTED, InputError
from heli_flight.nodes import live_parameters
from heli_flight.nodes.message_text import field_text, fill, message_yaml
from heli_flight.topic_rate import BandwidthWindow, RateWindow

PRINT_SECONDS = 1.0

Options = argparse.Namespace


def say(text: str) -> None:
    """A line or lines on standard output, at once."""
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def topic_list(graph: LiveGraph, options: Options) -> None:
    """Names of the topics."""
    graph.settle()
    _say_names(graph.topics(), options.show_types)


def topic_info(graph: LiveGraph, options: Options) -> None:
    """Type and ends of a topic."""
    graph.settle()
    topic = graph.require(options.topic, graph.topics, "Unknown topic")
    types, node, gap = graph.topics()[topic], graph.node, "\n" if options.verbose else ""
    say(f"Type: {types[0] if len(types) == 1 else types}{gap}")
    for name, ends in (
        ("Publisher", node.get_publishers_info_by_topic(topic)),
        ("Subscription", node.get_subscriptions_info_by_topic(topic)),
    ):
        say(f"{name} count: {len(ends)}{gap}")
        for end in ends if options.verbose else ():
            say(f"{end}\n")


def topic_echo(graph: LiveGraph, options: Options) -> None:
    """Every message, or one."""
    heard: list[Any] = []
    _listen(graph, options.topic, heard.append, raw=False)
    while True:
        graph.turn()
        for message in heard:
            text = field_text(message, options.field) if options.field else message_yaml(message)
            say(f"{text}---")
            if options.once:
                return
        heard.clear()


def topic_hz(graph: LiveGraph, options: Options) -> None:
    """How often messages come, every second."""
    window = RateWindow(options.window)
    _measure(graph, options.topic, lambda _: window.add(perf_counter()), window.text)


def topic_bw(graph: LiveGraph, options: Options) -> None:
    """How many bytes come, every second."""
    window = BandwidthWindow(options.window)

    def hear(data: bytes) -> None:
        window.add(perf_counter(), len(data))

    first = f"Subscribed to [{options.topic}]"
    _measure(graph, options.topic, hear, lambda: window.text(perf_counter()), first)


def node_list(graph: LiveGraph, _: Options) -> None:
    """Names of the nodes."""
    graph.settle()
    say("\n".join(graph.nodes()))


def node_info(graph: LiveGraph, options: Options) -> None:
    """What a node takes and gives."""
    graph.settle()
    full = graph.require(options.node, graph.nodes, "Unable to find node")
    space, _, name = full.rpartition("/")
    node, place = graph.node, (name, space or "/")
    say(full)
    for title, names in (
        ("Subscribers", node.get_subscriber_names_and_types_by_node(*place)),
        ("Publishers", node.get_publisher_names_and_types_by_node(*place)),
        ("Service Servers", node.get_service_names_and_types_by_node(*place)),
        ("Service Clients", node.get_client_names_and_types_by_node(*place)),
        ("Action Servers", get_action_server_names_and_types_by_node(node, *place)),
        ("Action Clients", get_action_client_names_and_types_by_node(node, *place)),
    ):
        say(f"  {title}:")
        say("\n".join(f"    {name}: {', '.join(types)}" for name, types in sorted(names) if "/_" not in name))


def service_list(graph: LiveGraph, options: Options) -> None:
    """Names of the services."""
    graph.settle()
    _say_names(graph.services(), options.show_types)


def service_call(graph: LiveGraph, options: Options) -> None:
    """Call a service and show request and response."""
    kind = _interface(options.type, "srv")
    request = kind.Request()
    try:
        fill(request, yaml.safe_load(options.values) or {})
    except yaml.YAMLError as error:
        problem = str(error).splitlines()[0]
        raise InputError(f"no YAML: {problem}", allowed="fields of the request", key="YAML") from None
    service = graph.require(options.service, graph.services, "Unknown service")
    say(f"requester: making request: {request!r}\n")
    say(f"response:\n{graph.ask(kind, service, request)!r}\n")


VERBS: dict[tuple[str, str], Callable[[LiveGraph, Options], None]] = {
    ("topic", "list"): topic_list,
    ("topic", "info"): topic_info,
    ("topic", "echo"): topic_echo,
    ("topic", "hz"): topic_hz,
    ("topic", "bw"): topic_bw,
    ("node", "list"): node_list,
    ("node", "info"): node_info,
    ("service", "list"): service_list,
    ("service", "call"): service_call,
    ("param", "list"): live_parameters.show_names,
    ("param", "describe"): live_parameters.describe,
    ("param", "get"): live_parameters.show_value,
    ("param", "set"): live_parameters.set_value,
}


def _say_names(names: dict[str, list[str]], show_types: bool) -> None:
    for name, types in names.items():
        say(f"{name} [{', '.join(types)}]" if show_types else name)


def _listen(graph: LiveGraph, name: str, hear: Callable[[Any], None], raw: bool) -> None:
    topic = graph.require(name, graph.topics, "Unknown topic")
    types = graph.topics()[topic]
    if len(types) != 1:
        raise InputError(f"topic '{topic}' has more than one type: {', '.join(types)}")
    graph.listen(topic, _interface(types[0], "msg"), hear, raw)


def _measure(
    graph: LiveGraph, topic: str, hear: Callable[[bytes], None], text: Callable[[], str], first: str = ""
) -> None:
    """Print a text every second in which a message has come."""
    come: list[int] = []

    def count(data: bytes) -> None:
        come.append(len(data))
        hear(data)

    _listen(graph, topic, count, raw=True)
    if first:
        say(first)
    due = perf_counter() + PRINT_SECONDS
    while True:
        graph.turn()
        if perf_counter() >= due and come:
            come.clear()
            due = perf_counter() + PRINT_SECONDS
            if line := text():
                say(line)


def _interface(name: str, kind: str) -> Any:
    """The class of a message or service by its name, with or without the word in the middle."""
    parts = name.split("/")
    try:
        return getattr(import_module(f"{parts[0]}.{kind}"), parts[-1])
    except (ImportError, AttributeError, ValueError):
        raise InputError(f"type {name!r} is not known here", allowed=f"PACKAGE/{kind}/NAME") from None


def main() -> int:
    """Do what the one argument says, a JSON object of the options; returns the exit code."""
    options = Options(**json.loads(sys.argv[1]))
    try:
        with LiveGraph() as graph:
            VERBS[options.word, options.verb](graph, options)
    except InputError as error:
        sys.stderr.write(f"heli {options.word}: {error}\n")
        return EXIT_BAD_INPUT
    except KeyboardInterrupt:
        # These three have no other end.
        endless = options.verb in ("echo", "hz", "bw")
        return EXIT_FLOWN if endless else EXIT_INTERRUPTED
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return EXIT_FLOWN


if __name__ == "__main__":
    sys.exit(main())
