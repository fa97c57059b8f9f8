"""A recorded bag, played into a live node, gives the recorded outputs back byte by byte."""

import sys

from heli_flight.bag_reader import read_bag

LISTENER = """
import sys
from heli_common.nodes.runner import ComponentProgram, run_node

class Listener:
    name, inputs, outputs, heard = "supervisor", ("odometry", "rotor_state"), (), 0

class Program(ComponentProgram):
    def on_message(self, topic, data):
        if topic == "odometry":
            print(data.hex(), flush=True)
            self.component.heard += 1
            self.finished = self.component.heard == int(sys.argv[1])

sys.exit(run_node("supervisor", lambda *_: Program(Listener()), sys.argv[2:]))
"""


def test_navigation_repeats_its_odometry(heli):
    assert heli("fly", "short_hover", "--mode", "inprocess", "--name", "b", "--no-report").returncode == 0
    bag = read_bag(heli.folder / "flights" / "b")
    expected = bag.messages["odometry"]
    running = ("--ros-args", "-p", "running:=replay,navigation,supervisor")
    listener = heli.start_process(sys.executable, "-c", LISTENER, str(len(expected)), *running)
    heli.start_process(sys.executable, "-m", "heli_navigation.nodes.navigation_node", *running)
    player = heli.start_process(
        *(sys.executable, "-m", "heli_flight.nodes.replay_node", "flights/b", *running),
        *("-p", "topics:=encoders,imu,rotor", "-p", "rate:=2.0"),
    )
    out, _ = listener.communicate(timeout=60)
    heard = [bytes.fromhex(line) for line in out.split()]
    assert heard == expected
    assert player.wait(10) == 0


def test_replay_refuses_what_is_not_there(heli):
    for words, said in (
        (["nowhere"], "nowhere"),
        (["--ros-args", "-p", "bag:=nowhere", "-p", "rate:=-1.0"], "rate"),
        ([], "no folder given"),
    ):
        player = heli.start_process(sys.executable, "-m", "heli_flight.nodes.replay_node", *words)
        _, error = player.communicate(timeout=30)
        assert player.returncode == 2
        assert said in error
        assert len(error.strip().splitlines()) == 1
