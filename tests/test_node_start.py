"""How a node begins: it says that it is ready when nothing is left that takes long."""

import json
import os
import sys

STARTS = """
import json, os, sys
from heli_common.nodes import connection, runner

did = []
real_open = connection.Connection.open

def note_open(self):
    done = real_open(self)
    if done:
        did.append("ready")
    return done

connection.Connection.open = note_open
runner.become_real_time = lambda priority: did.append(f"scheduled {priority}") or ""

class Program:
    name, inputs, outputs, waking, ends = "motor_controller", (), (), (), True
    finished = False
    def start(self, connection):
        threads = [int(name) for name in os.listdir("/proc/self/task")]
        did.append(sorted({core for thread in threads for core in os.sched_getaffinity(thread)}))
        self.finished = True
    def turn(self): return 0.01
    def on_message(self, topic, data): pass
    def close(self): did.append("closed")

words = ["--ros-args", "-p", "real_time_priority:=7", "-p", f"core:={sys.argv[1]}"]
code = runner.run_node("motor_controller", lambda *_: Program(), words)
print(json.dumps([code, did]))
"""


CORES = sorted(os.sched_getaffinity(0))


def started(heli, core):
    """What a node did that is to stay on a core, and what it said."""
    process = heli.start_process(sys.executable, "-c", STARTS, str(core))
    out, error = process.communicate(timeout=60)
    assert process.returncode == 0, error
    return json.loads(out), error


def test_a_node_schedules_itself_before_it_says_that_it_is_ready(heli):
    assert started(heli, -1) == ([0, ["scheduled 7", "ready", CORES, "closed"]], "")


def test_all_threads_of_a_node_stay_on_its_core(heli):
    assert started(heli, CORES[-1])[0] == [0, ["scheduled 7", "ready", CORES[-1:], "closed"]]


def test_a_node_whose_core_does_not_exist_says_so_and_runs_on_any(heli):
    (code, did), error = started(heli, 8191)
    assert (code, did[2]) == (0, CORES)
    assert (
        error.startswith("motor_controller: warning: core 8191 is not to be had (") and error.count("\n") == 1
    )
