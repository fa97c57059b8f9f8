"""The launch file starts the nodes of the process table; a stand-in takes the place of launch itself."""

import importlib.util
import json
import os
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from heli_control.controller_file import load_controller
from heli_flight.fly_graph import command
from heli_flight.mode import Mode
from heli_flight.order import FlightOrder
from heli_flight.plan import load_plan
from heli_flight.process_table import PROCESSES, Process, processes

WORKSPACE = Path(__file__).resolve().parents[1] / "ros_ws"
LAUNCH_FILE = WORKSPACE / "launch/bench.launch.py"
SCRIPTS = WORKSPACE / "scripts"

PLAN = """
name: everything
about: a plan that has something to tell every node
seed: 1
controller: lq
room: gusty
faults:
  - {kind: encoder_stuck, encoder: arm_1, at_s: 20.0, for_s: 0.5}
phases:
  - home: {}
  - run_up: {}
  - take_off: {height: 0.0}
  - hover: {duration: 5.0, controller: ncf}
  - excite: {signal: prbs, channels: [B_1s, A_1s], amplitude_deg: 0.8, band_rad_s: [0.5, 12], duration: 10.0}
  - land: {}
  - run_down: {}
"""


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
    assert parameters(launched(launch_file)["supervisor"]).keys() == {"running", "real_time_priority"}


def test_every_node_is_in_the_given_namespace(launch_file: ModuleType) -> None:
    assert {node.namespace for node in launched(launch_file, namespace="left").values()} == {"left"}
    assert {node.namespace for node in launched(launch_file).values()} == {None}


def flown(mode: str, plan_file: str, bag: str) -> dict[str, dict[str, Any]]:
    """Parameters that `heli fly` gives to each node, read from its command lines."""
    plan = load_plan(plan_file)
    first, *later = plan.controllers
    order = FlightOrder(
        plan=plan,
        plan_name=plan_file,
        mode=Mode(mode),
        seed=7,
        controller=load_controller(first),
        controller_name=first,
        bag=Path(bag),
        later=tuple(load_controller(name) for name in later),
        later_names=tuple(later),
    )
    found = {}
    for process in processes(order.identified):
        words = command(process, order, Path("notes.json"))
        assert words[1:4] == ["-m", process.module, "--ros-args"]
        pairs = [words[at + 1].split(":=", 1) for at, word in enumerate(words) if word == "-p"]
        given = {key: json.loads(value) for key, value in pairs}
        found[process.name] = {key: value for key, value in given.items() if value != "" and key != "notes"}
    return found


@pytest.mark.parametrize("mode", ["lockstep", "realtime"])
def test_launched_nodes_are_told_what_flown_nodes_are_told(
    launch_file: ModuleType, mode: str, tmp_path: Path
) -> None:
    """Room, faults, excitations, later controllers and priorities of a plan reach the nodes on both ways."""
    plan = tmp_path / "plan.yaml"
    plan.write_text(PLAN)
    bag = str(tmp_path / "bag")
    nodes = launched(launch_file, plan=str(plan), controller="lq", mode=mode, seed="7", bag=bag)
    told = {name: parameters(node) for name, node in nodes.items()}
    assert told == flown(mode, str(plan), bag)
    assert told["bench_sim"].keys() >= {"faults", "room.active"}
    assert told["attitude_controller"]["plan_controllers"] == "lq,ncf"


@pytest.mark.parametrize("process", PROCESSES, ids=lambda process: process.name)
def test_script_starts_the_module_of_the_table_with_the_given_arguments(process: Process) -> None:
    script = SCRIPTS / process.script
    assert os.access(script, os.X_OK)
    *_, last = script.read_text().splitlines()
    assert last == f'run python -m {process.module} "$@"'
    assert importlib.util.find_spec(process.module) is not None


def test_no_script_starts_a_node_that_the_table_does_not_know() -> None:
    started = {
        word
        for script in SCRIPTS.glob("*.sh")
        for word in script.read_text().split()
        if ".nodes." in word and word.endswith("_node")
    }
    player = "heli_flight.nodes.replay_node"  # takes the bench's place, in no flight
    assert started == {process.module for process in PROCESSES} | {player}
