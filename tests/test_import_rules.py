"""The law of the house on who may import whom; sources are parsed, nothing is imported.

Imports point down only: nodes -> the package's own maths and heli_common; maths -> heli_common's pure half.
"""

import ast
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = {
    "heli_common": ROOT / "ros_ws/src/heli_common",
    "heli_bench_sim": ROOT / "heli_bench_sim",
    "heli_navigation": ROOT / "heli_navigation",
    "heli_control": ROOT / "heli_control",
    "heli_identification": ROOT / "heli_identification",
    "heli_flight": ROOT / "ros_ws/src/heli_flight",
}
# These know the bench by its messages and files alone.
APART = ("heli_navigation", "heli_control", "heli_identification")
# Whoever starts processes, waits for them or tells how long something took; nobody else outside nodes/.
READS_THE_CLOCK = (
    "heli_flight.cli",
    "heli_flight.fly_graph",
    "heli_flight.fly_in_process",
    "heli_flight.process_group",
    "heli_flight.warm_up",
)
COMPILED = "heli_common.compiled"

ROS_FAMILIES = ("rclpy", "rcl", "rmw", "rosidl", "rpyutils", "ament", "launch", "tf2", "builtin")
ROS_ENDINGS = ("_msgs", "_srvs", "_interfaces")


class Import(NamedTuple):
    """One imported name, in full, and where."""

    name: str
    line: int


class Source(NamedTuple):
    """A parsed module: its dotted name, whether it is an __init__, and its text as a tree."""

    module: str
    is_package: bool
    tree: ast.Module

    @property
    def package(self) -> str:
        return self.module.partition(".")[0]

    @property
    def parts(self) -> list[str]:
        return self.module.split(".")

    @property
    def is_node(self) -> bool:
        return "nodes" in self.parts[1:]

    def imports(self) -> Iterator[Import]:
        """Every import at any depth, relative ones resolved, `import_module("...")` included."""
        for node in ast.walk(self.tree):
            match node:
                case ast.Import(names=names):
                    yield from (Import(alias.name, node.lineno) for alias in names)
                case ast.ImportFrom(module=module, names=names, level=level):
                    base = module or ""
                    if level:
                        up = level - 1 if self.is_package else level
                        above = self.parts[: len(self.parts) - up]
                        base = ".".join([*above, *([module] if module else [])])
                    yield from (Import(f"{base}.{alias.name}", node.lineno) for alias in names)
                case ast.Call(func=func, args=[ast.Constant(value=str(name)), *_]):
                    if called(func) in ("import_module", "__import__"):
                        yield Import(name, node.lineno)


def within(name: str, parents: tuple[str, ...]) -> bool:
    """Whether a dotted name is one of the parents or inside one of them."""
    return any(name == parent or name.startswith(parent + ".") for parent in parents)


def called(function: ast.expr) -> str:
    """The last name of a called function: `sleep` of `asyncio.sleep(1)`."""
    match function:
        case ast.Name(id=name) | ast.Attribute(attr=name):
            return name
    return ""


def is_ros(name: str) -> bool:
    """Whether an import comes from ROS; rosbags and mcap are plain Python packages."""
    top = name.partition(".")[0]
    return top.partition("_")[0] in ROS_FAMILIES or top.endswith(ROS_ENDINGS)


def is_nodes_module(name: str) -> bool:
    """Whether an import is of heli_x.nodes or something in it."""
    parts = name.split(".")
    return parts[0] in PACKAGES and "nodes" in parts[1:]


Complaints = Iterator[str]


def complain(source: Source, found: Import, reason: str) -> str:
    return f"{source.module}:{found.line} imports {found.name}: {reason}"


def maths_knows_no_ros(source: Source) -> Complaints:
    """Only nodes/ may import ROS."""
    if source.is_node:
        return
    for found in source.imports():
        if is_ros(found.name):
            yield complain(source, found, "ROS belongs in nodes/")


def maths_knows_no_nodes(source: Source) -> Complaints:
    """Imports point down: nobody outside nodes/ imports a nodes module."""
    if source.is_node:
        return
    for found in source.imports():
        if is_nodes_module(found.name):
            yield complain(source, found, "imports point down only, from nodes/ to maths")


def siblings_stay_apart(source: Source) -> Complaints:
    """heli_common imports no sibling, the three apart heli_common alone, and heli_flight is on top of all."""
    allowed = {source.package, "heli_common"}
    for found in source.imports():
        top = found.name.partition(".")[0]
        if top not in PACKAGES or top in allowed or source.package == "heli_flight":
            continue
        if source.package == "heli_common" or source.package in APART or top == "heli_flight":
            yield complain(source, found, f"{source.package} must not know {top}")


def one_door_to_numba(source: Source) -> Complaints:
    """The cache folder must be set before numba is imported, so only heli_common.compiled imports it."""
    if source.module == COMPILED:
        return
    for found in source.imports():
        if within(found.name, ("numba",)):
            yield complain(source, found, f"use {COMPILED}")


def maths_reads_no_clock(source: Source) -> Complaints:
    """Time is handed to the maths as a stamp or a step."""
    if source.is_node or within(source.module, READS_THE_CLOCK):
        return
    for found in source.imports():
        if within(found.name, ("time",)):
            yield complain(source, found, "maths gets its time as an argument")


def no_test_sleeps(source: Source) -> Complaints:
    """A test waits for what it needs, up to a deadline."""
    for found in source.imports():
        if found.name.rpartition(".")[2] == "sleep":
            yield complain(source, found, "a test waits for what it needs")
    for node in ast.walk(source.tree):
        if isinstance(node, ast.Call) and called(node.func) == "sleep":
            yield f"{source.module}:{node.lineno} sleeps"


def packages_of_two_siblings(sources: list[Source]) -> dict[str, set[str]]:
    """The packages other than heli_flight that import two or more of their siblings, and which."""
    siblings: dict[str, set[str]] = defaultdict(set)
    for source in sources:
        for found in source.imports():
            top = found.name.partition(".")[0]
            if top in PACKAGES and top not in (source.package, "heli_common"):
                siblings[source.package].add(top)
    return {name: known for name, known in siblings.items() if len(known) > 1 and name != "heli_flight"}


def parse(module: str, text: str, *, is_package: bool = False) -> Source:
    return Source(module, is_package, ast.parse(text))


def read(folder: Path, prefix: str = "") -> list[Source]:
    """All sources below a folder; module names are relative to it."""
    sources = []
    for path in sorted(folder.rglob("*.py")):
        parts = path.relative_to(folder).with_suffix("").parts
        is_package = parts[-1] == "__init__"
        module = ".".join([*([prefix] if prefix else []), *(parts[:-1] if is_package else parts)])
        sources.append(parse(module, path.read_text(encoding="utf-8"), is_package=is_package))
    return sources


@pytest.fixture(scope="module")
def package_sources() -> list[Source]:
    return [source for name, root in PACKAGES.items() for source in read(root / name, name)]


@pytest.fixture(scope="module")
def sources_of_tests() -> list[Source]:
    folders = [*(root / "test" for root in PACKAGES.values()), ROOT / "tests"]
    return [source for folder in folders for source in read(folder)]


MODULE_RULES = [
    maths_knows_no_ros,
    maths_knows_no_nodes,
    siblings_stay_apart,
    one_door_to_numba,
    maths_reads_no_clock,
]


@pytest.mark.parametrize("rule", MODULE_RULES, ids=lambda rule: rule.__name__)
def test_sources_follow(rule: Callable[[Source], Complaints], package_sources: list[Source]) -> None:
    complaints = [complaint for source in package_sources for complaint in rule(source)]
    assert not complaints, "\n".join(complaints)


@pytest.mark.parametrize("rule", [no_test_sleeps, one_door_to_numba], ids=lambda rule: rule.__name__)
def test_tests_follow(rule: Callable[[Source], Complaints], sources_of_tests: list[Source]) -> None:
    complaints = [complaint for source in sources_of_tests for complaint in rule(source)]
    assert not complaints, "\n".join(complaints)


def test_only_heli_flight_imports_two_siblings(package_sources: list[Source]) -> None:
    assert packages_of_two_siblings(package_sources) == {}


def test_all_packages_are_read(package_sources: list[Source], sources_of_tests: list[Source]) -> None:
    assert {source.package for source in package_sources} == set(PACKAGES)
    assert COMPILED in {source.module for source in package_sources}
    assert Path(__file__).stem in {source.module for source in sources_of_tests}


@pytest.mark.parametrize(
    ("rule", "module", "text"),
    [
        (maths_knows_no_ros, "heli_control.attitude", "import rclpy"),
        (maths_knows_no_ros, "heli_control.attitude", "def f():\n    from rclpy.node import Node"),
        (maths_knows_no_ros, "heli_common.layout", "from sensor_msgs.msg import Imu"),
        (maths_knows_no_ros, "heli_flight.plan", "from std_srvs.srv import Trigger"),
        (
            maths_knows_no_ros,
            "heli_flight.plan",
            "from importlib import import_module\nimport_module('rclpy')",
        ),
        (maths_knows_no_ros, "heli_flight.plan", "from launch_ros.actions import Node"),
        (maths_knows_no_ros, "heli_flight.plan", "import rcl_interfaces.msg"),
        (maths_knows_no_ros, "heli_flight.cli.main", "import rclpy"),
        (maths_knows_no_nodes, "heli_bench_sim.inflow", "from heli_bench_sim.nodes import bench_program"),
        (maths_knows_no_nodes, "heli_bench_sim.inflow", "from .nodes.bench_program import BenchProgram"),
        (maths_knows_no_nodes, "heli_bench_sim.inflow", "from . import nodes"),
        (maths_knows_no_nodes, "heli_bench_sim.inflow", "import heli_common.nodes.runner"),
        (siblings_stay_apart, "heli_common.topics", "import heli_control"),
        (siblings_stay_apart, "heli_common.nodes.runner", "import heli_flight.plan"),
        (siblings_stay_apart, "heli_navigation.arm_kinematics", "from heli_bench_sim.arm import position"),
        (siblings_stay_apart, "heli_control.nodes.motor_controller_node", "import heli_bench_sim"),
        (siblings_stay_apart, "heli_identification.pem", "from heli_control import lq"),
        (siblings_stay_apart, "heli_bench_sim.bench", "from heli_flight.plan import Plan"),
        (one_door_to_numba, "heli_bench_sim.inflow", "from numba import njit"),
        (one_door_to_numba, "heli_bench_sim.nodes.bench_sim_node", "import numba as nb"),
        (one_door_to_numba, "test_inflow", "import numba.core.config"),
        (maths_reads_no_clock, "heli_flight.supervisor", "from time import monotonic"),
        (maths_reads_no_clock, "heli_flight.clip", "import time"),
        (no_test_sleeps, "test_graph", "from time import sleep as rest"),
        (no_test_sleeps, "test_graph", "import time\ntime.sleep(0.1)"),
        (no_test_sleeps, "test_graph", "async def f():\n    await asyncio.sleep(1)"),
        (no_test_sleeps, "test_graph", "sleep(1)"),
    ],
)
def test_rule_sees(rule: Callable[[Source], Complaints], module: str, text: str) -> None:
    (complaint,) = rule(parse(module, text))
    assert complaint.startswith(f"{module}:{len(text.splitlines())} ")


@pytest.mark.parametrize(
    ("module", "text"),
    [
        ("heli_control.nodes.attitude_controller_node", "import rclpy\nfrom sensor_msgs.msg import Imu"),
        ("heli_control.nodes.attitude_controller_node", "from heli_common.nodes.runner import run_node"),
        ("heli_control.nodes.attitude_controller_node", "from ..attitude import Attitude\nimport time"),
        ("heli_flight.cli.main", "import time, heli_control.lq, heli_bench_sim.bench"),
        ("heli_flight.in_process", "from heli_bench_sim.bench import Bench\nimport heli_navigation.kalman"),
        ("heli_flight.bag", "import rosbags.rosbag2\nimport mcap"),
        ("heli_common.compiled", "import numba"),
        ("heli_identification.pem", "import numpy as np\nfrom heli_common.compiled import compiled"),
        ("heli_identification.timetable", "from .timing import step"),
    ],
)
def test_rules_allow(module: str, text: str) -> None:
    source = parse(module, text)
    assert [complaint for rule in MODULE_RULES for complaint in rule(source)] == []


def test_two_siblings_are_seen() -> None:
    one = parse("heli_bench_sim.arm", "import heli_navigation.arm_kinematics, heli_common")
    two = parse("heli_bench_sim.bench", "from heli_control import motor")
    flight = parse("heli_flight.in_process", "import heli_navigation, heli_control")
    assert packages_of_two_siblings([one, flight]) == {}
    assert packages_of_two_siblings([one, two]) == {"heli_bench_sim": {"heli_navigation", "heli_control"}}


@pytest.mark.parametrize(
    ("module", "is_package", "text", "name"),
    [
        ("heli_x.nodes.a", False, "from . import b", "heli_x.nodes.b"),
        ("heli_x.nodes.a", False, "from ..c import d", "heli_x.c.d"),
        ("heli_x.nodes", True, "from .a import d", "heli_x.nodes.a.d"),
        ("heli_x", True, "from . import nodes", "heli_x.nodes"),
    ],
)
def test_relative_imports_are_resolved(module: str, is_package: bool, text: str, name: str) -> None:
    assert list(parse(module, text, is_package=is_package).imports()) == [Import(name, 1)]
