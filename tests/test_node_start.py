"""How a node begins: it says that it is ready when nothing is left that takes long."""

import json
import sys

STARTS = """
import json
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
        did.append("started")
        self.finished = True
    def turn(self): return 0.01
    def on_message(self, topic, data): pass
    def close(self): did.append("closed")

words = ["--ros-args", "-p", "real_time_priority:=7"]
code = runner.run_node("motor_controller", lambda *_: Program(), words)
print(json.dumps([code, did]))
"""


def test_a_node_schedules_itself_before_it_says_that_it_is_ready(heli):
    process = heli.start_process(sys.executable, "-c", STARTS)
    out, error = process.communicate(timeout=60)
    assert process.returncode == 0, error
    assert json.loads(out) == [0, ["scheduled 7", "ready", "started", "closed"]]
