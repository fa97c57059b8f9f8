"""`heli topic`, `node`, `param` and `service`: the words of ros2cli where it is not installed.

Only nodes/ knows ROS. So the command reads its words here and then becomes the program that looks at the
graph, with the environment in which flights find each other.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from typing import Any

from heli_flight.process_table import environment
from heli_flight.topic_rate import BANDWIDTH_WINDOW, RATE_WINDOW

PROGRAM = "heli_flight.nodes.graph_tool"


def add_parser(words: Any) -> None:
    """Add the four words to the command."""
    _topic(_verbs(words, "topic", "look at the topics of a live graph"))
    node = _verbs(words, "node", "look at the nodes of a live graph")
    _verb(node, "list", "names of the nodes")
    _verb(node, "info", "what a node takes and gives", "node")
    _param(_verbs(words, "param", "read and set the parameters of live nodes"))
    _service(_verbs(words, "service", "look at the services of a live graph and call them"))


def run(options: argparse.Namespace) -> int:
    """Become the program that looks at the graph; does not return."""
    given = {key: value for key, value in vars(options).items() if key != "func"}
    command = [sys.executable, "-m", PROGRAM, json.dumps(given)]
    os.execve(sys.executable, command, environment())


def _topic(verbs: Any) -> None:
    names = _verb(verbs, "list", "names of the topics")
    names.add_argument("-t", "--show-types", action="store_true", help="their types, too")
    info = _verb(verbs, "info", "type and number of publishers and subscriptions", "topic")
    info.add_argument("-v", "--verbose", action="store_true", help="every end with its quality of service")
    echo = _verb(verbs, "echo", "print the messages", "topic")
    echo.add_argument("--once", action="store_true", help="print one message and end")
    echo.add_argument(
        "--field", metavar="FIELD", help="only this part, e.g. pose.pose.position or position[0]"
    )
    rate = _verb(verbs, "hz", "print how often messages come", "topic")
    _window(rate, RATE_WINDOW)
    bandwidth = _verb(verbs, "bw", "print how many bytes come", "topic")
    _window(bandwidth, BANDWIDTH_WINDOW)


def _param(verbs: Any) -> None:
    names = _verb(verbs, "list", "names of the parameters")
    names.add_argument("node", nargs="?", metavar="NODE", help="of this node only")
    describe = _verb(verbs, "describe", "type, text, unit and range of parameters", "node")
    describe.add_argument("parameters", nargs="+", metavar="PARAM", help="names of parameters")
    get = _verb(verbs, "get", "value of a parameter", "node")
    get.add_argument("parameter", metavar="PARAM", help="name of a parameter")
    put = _verb(verbs, "set", "set a parameter", "node")
    put.add_argument("parameter", metavar="PARAM", help="name of a parameter")
    put.add_argument("value", metavar="VALUE", help="as in YAML")


def _service(verbs: Any) -> None:
    names = _verb(verbs, "list", "names of the services")
    names.add_argument("-t", "--show-types", action="store_true", help="their types, too")
    call = _verb(verbs, "call", "call a service", "service")
    call.add_argument("type", metavar="TYPE", help="e.g. std_srvs/srv/Trigger")
    call.add_argument("values", nargs="?", default="{}", metavar="YAML", help="of the request")


def _verbs(words: Any, word: str, text: str) -> Any:
    parser = words.add_parser(word, help=text, description=f"{text[0].upper()}{text[1:]}.")
    return parser.add_subparsers(dest="verb", required=True, metavar="VERB")


def _verb(verbs: Any, verb: str, text: str, name: str = "") -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = verbs.add_parser(
        verb, help=text, description=f"{text[0].upper()}{text[1:]}."
    )
    if name:
        parser.add_argument(name, metavar=name.upper(), help=f"name of the {name}, with its namespace")
    parser.set_defaults(func=run)
    return parser


def _window(parser: argparse.ArgumentParser, size: int) -> None:
    text = f"over how many messages (default: {size})"
    parser.add_argument("-w", "--window", type=_positive, default=size, metavar="N", help=text)


def _positive(text: str) -> int:
    value = int(text)
    if value < 1:
        raise ValueError(text)
    return value
