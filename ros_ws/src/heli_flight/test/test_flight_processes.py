"""Groups of processes: read, stopped and never left behind; progress lines; the table of nodes."""

import json
import os
import signal
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from time import monotonic

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heli_common.flight_state import FlightState
from heli_common.topics import DATA_TOPICS, OPTIONAL_NODES, TOPICS, data_topics
from heli_control.controller_file import load_controller
from heli_flight import fly_graph
from heli_flight.mode import Mode
from heli_flight.node_settings import FlightSettings
from heli_flight.order import FlightOrder
from heli_flight.plan import load_plan
from heli_flight.process_group import ProcessGroup
from heli_flight.process_table import NODE_NAMES, processes
from heli_flight.progress import Progress, parse

PATIENCE = 20.0


def python(code):
    return [sys.executable, "-c", code]


def read_until(group, enough):
    lines, deadline = [], monotonic() + PATIENCE
    while not enough(lines):
        assert monotonic() < deadline, lines
        lines += group.read(0.1)
    return lines


def test_lines_come_with_their_process_and_stream():
    commands = {
        "a": python("print('out'); import sys; print('bad', file=sys.stderr)"),
        "b": python("import sys; sys.stdout.write('no end of line')"),
    }
    with ProcessGroup(commands, os.environ) as group:
        lines = read_until(group, lambda seen: len(seen) == 3)
    assert sorted(lines) == [("a", False, "out"), ("a", True, "bad"), ("b", False, "no end of line")]


def test_stop_interrupts_then_kills_within_three_seconds():
    wait = "print('up', flush=True)\nwhile True: time.sleep(9)"
    polite = f"import signal, time; signal.signal(2, lambda *_: exit(7)); {wait}"
    deaf = f"import signal, time; signal.signal(2, signal.SIG_IGN); {wait}"
    with ProcessGroup({"polite": python(polite), "deaf": python(deaf)}, os.environ) as group:
        read_until(group, lambda seen: len(seen) == 2)
        pids = group.process_ids()
        started = monotonic()
        group.stop()
        assert monotonic() - started < 3.0
    for pid in pids.values():
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)


def test_exit_codes_and_signals_are_told_apart():
    commands = {"bad": python("exit(2)"), "killed": python("import os; os.kill(os.getpid(), 9)")}
    with ProcessGroup(commands, os.environ) as group:
        deadline = monotonic() + PATIENCE
        while len(group.exited()) < 2:
            assert monotonic() < deadline
            group.read(0.05)
        assert group.exited() == {"bad": 2, "killed": -signal.SIGKILL}


def test_children_go_with_a_killed_parent():
    parent = (
        "import os, sys\n"
        "from heli_flight.process_group import ProcessGroup\n"
        "group = ProcessGroup({'a': [sys.executable, '-c', 'import time; time.sleep(60)']}, os.environ)\n"
        "print(group.process_ids()['a'], flush=True)\n"
        "os.kill(os.getpid(), 9)\n"
    )
    ran = subprocess.run(python(parent), capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert ran.returncode == -signal.SIGKILL
    child, deadline = int(ran.stdout), monotonic() + PATIENCE
    while _runs(child):
        assert monotonic() < deadline


def _runs(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


@given(
    st.integers(0, 99_999),
    st.sampled_from(FlightState),
    st.integers(0, 99),
    st.integers(0, 99),
    st.sampled_from(["", "rotor speed 3.0 rad/s is too low to fly at 3.00 s"]),
)
def test_progress_survives_the_pipe(tenths, state, phase, phases, reason):
    progress = Progress(tenths / 10, state, phase, phases, reason)
    assert parse(progress.line() + "\n") == progress


def test_other_lines_are_no_progress():
    assert parse("navigation: ready") is None
    assert parse("   1.0 s  dancing  phase 1/2") is None


def test_every_source_and_listener_of_the_topics_is_a_process():
    assert {topic.source for topic in TOPICS.values()} <= set(NODE_NAMES)
    assert {name for topic in TOPICS.values() for name in topic.listeners} <= set(NODE_NAMES)


def test_the_identification_is_an_eighth_process():
    without, all_of_them = processes(identified=False), processes(identified=True)
    assert set(all_of_them) - set(without) == {p for p in all_of_them if p.name in OPTIONAL_NODES}
    assert (len(without), len(all_of_them)) == (7, 8)
    names = [p.name for p in without]
    assert {TOPICS[topic].source for topic in data_topics(names)} == set(names) - {"recorder"}
    assert data_topics(NODE_NAMES) == DATA_TOPICS


def order(mode, scheduled=True):
    plan = load_plan("hover")
    controller = load_controller(plan.controller)
    return FlightOrder(plan, "hover", mode, 1, controller, plan.controller, Path("b"), None, scheduled)


@pytest.mark.parametrize(
    ("mode", "names"),
    [
        (Mode.LOCKSTEP, {each.name for each in processes(False)}),
        (Mode.REALTIME, {each.name for each in processes(False)}),
        (Mode.COMPOSED, {"composed"}),
        (Mode.REALTIME_COMPOSED, {"composed", "recorder"}),
    ],
)
def test_which_nodes_share_a_process(tmp_path, mode, names):
    commands = fly_graph._commands(order(mode), tmp_path / "notes.json")
    assert set(commands) == names
    if mode.composed:
        shared = json.loads((tmp_path / "composed.json").read_text())
        assert set(shared) == {each.name for each in processes(False)} - names


def test_nobody_in_lockstep_interrupts_one_who_answers_him_and_the_recorder_nobody():
    settings = FlightSettings.of_order(order(Mode.LOCKSTEP), "")
    priority = {each.name: settings.of(each, NODE_NAMES)["real_time_priority"] for each in processes(True)}
    recorder = priority.pop("recorder")
    assert len(set(priority.values())) == 1
    assert 0 < recorder < priority["bench_sim"]


@pytest.mark.parametrize("mode", [mode for mode in Mode if mode.paced])
def test_the_bench_comes_first_and_the_recorder_last_in_real_time(mode):
    settings = FlightSettings.of_order(order(mode), "")
    priority = {each.name: settings.of(each, NODE_NAMES)["real_time_priority"] for each in processes(True)}
    assert sorted(priority, key=priority.get)[:: len(priority) - 1] == ["recorder", "bench_sim"]


@pytest.mark.parametrize("mode", [Mode.LOCKSTEP, Mode.COMPOSED, Mode.REALTIME])
def test_ordinary_scheduling_where_it_is_asked_for(mode):
    settings = FlightSettings.of_order(order(mode, scheduled=False), "")
    assert {settings.of(each, NODE_NAMES)["real_time_priority"] for each in processes(True)} == {0}


def cores_of(mode, cores, scheduled=True):
    """Core of each node that is told one."""
    settings = replace(FlightSettings.of_order(order(mode, scheduled=scheduled), ""), cores=cores)
    told = {each.name: settings.of(each, NODE_NAMES) for each in processes(True)}
    return {name: own["core"] for name, own in told.items() if "core" in own}


def test_in_lockstep_those_that_answer_each_other_have_a_core_each_of_two():
    core = cores_of(Mode.LOCKSTEP, (2, 5))
    chain = ["bench_sim", "navigation", "supervisor", "position_controller", "attitude_controller"]
    assert {core[name] for name in chain} == {2, 5}
    assert all(core[first] != core[second] for first, second in pairwise(chain))
    assert core["recorder"] == -1, "wherever there is room"


@pytest.mark.parametrize("cores", [(), (3,), (0, 1, 2)])
def test_with_one_core_or_more_than_two_all_run_anywhere(cores):
    assert set(cores_of(Mode.LOCKSTEP, cores).values()) == {-1}


def test_nobody_has_a_core_of_his_own_where_time_is_kept_or_ordinary_scheduling_asked_for():
    assert cores_of(Mode.REALTIME, (0, 1)) == {}
    assert cores_of(Mode.LOCKSTEP, (0, 1), scheduled=False) == {}
    assert FlightSettings.of_order(order(Mode.COMPOSED), "").cores == (), "nodes share a process"


def test_a_warning_that_holds_for_all_nodes_is_said_once(monkeypatch):
    def saying(name, *warnings):
        lines = "; ".join(f"print('{name}: warning: {each}', file=sys.stderr)" for each in warnings)
        return python(f"import sys; {lines}")

    nodes = {"bench_sim": ("all", "own"), "recorder": ("all",)}
    commands = {name: saying(name, *warnings) for name, warnings in nodes.items()}
    monkeypatch.setattr(fly_graph, "_commands", lambda *_: commands)
    monkeypatch.setattr(fly_graph, "is_warm", lambda: True)
    said = []
    assert fly_graph.fly_graph(order(Mode.LOCKSTEP), lambda _: None, said.append).exit_code == 0
    assert sorted(line.partition(": warning: ")[2] for line in said) == ["all", "own"]
