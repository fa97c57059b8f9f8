"""Two benches in one ROS domain, each in a namespace of its own, fly as if they were alone; one is looked at."""

import json

from heli_common.body_frame import SHOWN_PERIOD_NS, TF, TRANSFORM
from heli_flight.bag_reader import read_bag

PLAN = """
name: hop
about: as short as a flight can be
seed: 1
controller: lq
phases:
  - home: {duration: 6.0}
  - run_up: {duration: 4.0}
  - take_off: {height: 0.0, speed: 0.5}
  - land: {speed: 0.4}
  - run_down: {duration: 0.5}
"""
PLACES = ("left", "right/second")


def command(mode, name, *more):
    return ("fly", "hop.yaml", "--mode", mode, "--name", name, "--json", "--no-report", *more)


def test_two_benches_in_two_namespaces_do_not_touch_each_other(heli):
    (heli.folder / "hop.yaml").write_text(PLAN)
    alone = heli(*command("inprocess", "alone"))
    assert alone.returncode == 0, alone.stderr
    # one of them with another seed: a message from next door would change the hash
    seeds = ("1", "2")
    flights = [
        heli.start(*command("lockstep", f"bag_{seed}", "--namespace", place, "--seed", seed))
        for place, seed in zip(PLACES, seeds, strict=True)
    ]
    picture = heli.start("topic", "echo", "/left/markers", "--once")
    ended = [(*flight.communicate(timeout=90), flight.returncode) for flight in flights]
    assert [code for _, _, code in ended] == [0, 0], ended
    first, second = (json.loads(out) for out, _, _ in ended)
    assert first["sha256"] == json.loads(alone.stdout)["sha256"]
    other = json.loads(heli(*command("inprocess", "other", "--seed", "2")).stdout)
    assert second["sha256"] == other["sha256"] != first["sha256"]
    assert first["lost_messages"] == second["lost_messages"] == 0
    shown, error = picture.communicate(timeout=20)
    assert picture.returncode == 0, error
    for part in ("upper_arms", "forearms", "gimbal", "helicopter", "rotor_disc", "wind"):
        assert f"  ns: {part}\n" in shown

    for name in ("alone", "bag_1"):
        bag = read_bag(heli.folder / "flights" / name)
        assert bag.types[TF] == "tf2_msgs/msg/TFMessage"
        assert set(bag.stamps[TF]) == set(bag.stamps["ground_truth"][:: SHOWN_PERIOD_NS // 10_000_000])
        truth = bag.messages["ground_truth"]
        assert TRANSFORM.stamp(bag.messages[TF][1]) == SHOWN_PERIOD_NS
        assert len(truth) // 5 <= len(bag.messages[TF]) <= len(truth) // 5 + 1


def test_namespaces_are_refused_where_they_mean_nothing_or_are_no_names(heli):
    for words, said in (
        (("--mode", "inprocess", "--namespace", "left"), "--namespace: in mode inprocess"),
        (("--namespace", "2nd"), "--namespace: '2nd' (allowed: letters"),
    ):
        ran = heli("fly", "short_hover", *words)
        assert (ran.returncode, ran.stderr.count("\n")) == (2, 1)
        assert said in ran.stderr
