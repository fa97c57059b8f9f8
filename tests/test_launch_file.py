"""The launch file starts the nodes of the process table; a stand-in takes the place of launch itself."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from heli_flight.process_table import PROCESSES

LAUNCH_FILE = Path(__file__).resolve().parents[1] / "ros_ws/launch/bench.launch.py"


class Action(SimpleNamespace):
    """Keeps what it was made with."""

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(arguments=arguments, **named)


@pytest.fixture
def launch_file(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    for module, names in {
        "launch": ["LaunchContext", "LaunchDescription"],
        "launch.actions": ["DeclareLaunchArgument", "OpaqueFunction", "Shutdown"],
        "launch_ros": [],
        "launch_ros.actions": ["Node"],
        "launch_ros.parameter_descriptions": ["ParameterValue"],
    }.items():
        stand_in = ModuleType(module)
        for name in names:
            setattr(stand_in, name, type(name, (Action,), {}))
        monkeypatch.setitem(sys.modules, module, stand_in)
    spec = importlib.util.spec_from_file_location("bench_launch", LAUNCH_FILE)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def launched(launch_file: ModuleType, **given: str) -> dict[str, Any]:
    """The launched nodes by name, with the arguments' defaults where none is given."""
    *declared, starter = launch_file.generate_launch_description().arguments[0]
    defaults = {argument.arguments[0]: argument.default_value for argument in declared}
    assert given.keys() <= defaults.keys()
    context = SimpleNamespace(launch_configurations=defaults | given)
    return {node.name: node for node in starter.function(context)}


def parameters(node: Any) -> dict[str, Any]:
    (given,) = node.parameters
    for value in given.values():
        assert isinstance(value.arguments[0], value.value_type)
    return {key: value.arguments[0] for key, value in given.items()}


def test_every_process_is_launched(launch_file: ModuleType) -> None:
    nodes = launched(launch_file, bag="flights/one", identification="true")
    assert [(n.package, n.executable) for n in nodes.values()] == [
        (p.package, p.executable) for p in PROCESSES
    ]
    assert {parameters(node)["running"] for node in nodes.values()} == {",".join(nodes)}
    assert [name for name, node in nodes.items() if not node.on_exit] == ["identification", "recorder"]


def test_a_plan_that_excites_brings_the_identification_along(launch_file: ModuleType) -> None:
    assert "identification" not in launched(launch_file, plan="short_hover")
    nodes = launched(launch_file, plan="identification", mode="lockstep")
    assert parameters(nodes["identification"])["excitations"].startswith('[{"signal": "prbs"')
    assert "identification" in parameters(nodes["bench_sim"])["running"]
    assert all(node.on_exit for node in nodes.values())


def test_arguments_reach_their_nodes(launch_file: ModuleType) -> None:
    nodes = launched(launch_file, plan="1", controller="hinf", mode="lockstep", seed="7")
    assert "recorder" not in nodes
    assert parameters(nodes["supervisor"])["plan"] == "1"
    assert parameters(nodes["attitude_controller"])["controller"] == "hinf"
    assert parameters(nodes["bench_sim"]).items() >= {"mode": "lockstep", "seed": 7}.items()
    assert all("recorder" not in parameters(node)["running"] for node in nodes.values())


def test_without_a_plan_none_is_set(launch_file: ModuleType) -> None:
    assert parameters(launched(launch_file)["supervisor"]).keys() == {"running"}
