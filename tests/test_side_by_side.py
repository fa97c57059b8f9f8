"""Two benches in one ROS domain, each in a namespace of its own, fly as if alone; one is looked at."""

import json

from brief import brief

from heli_common.body_frame import SHOWN_PERIOD_NS, TF, TRANSFORM
from heli_flight.bag_reader import read_bag

PLACES = ("left", "right/second")
ORDINARY = "--no-real-time-scheduling"
"""Else the flight is over before a program of ordinary priority has looked."""


def fly(heli, mode, name, *more):
    return heli.start("fly", "hop.yaml", "--mode", mode, "--name", name, "--json", "--no-report", *more)


def test_two_benches_in_two_namespaces_do_not_touch_each_other(heli, wait_for):
    (heli.folder / "hop.yaml").write_text(brief("hover: {duration: 10.0}"))  # long enough to be looked at
    # with another seed on the other bench, a message from next door would change the hash
    seeds = ("1", "2")
    alone = [fly(heli, "inprocess", f"alone_{seed}", "--seed", seed) for seed in seeds]
    beside = [
        fly(heli, "lockstep", f"beside_{seed}", "--seed", seed, "--namespace", place, ORDINARY)
        for seed, place in zip(seeds, PLACES, strict=True)
    ]

    def picture():
        looked = heli("topic", "echo", "/left/markers", "--once")
        return looked.stdout if looked.returncode == 0 else ""

    shown = wait_for(picture)
    for part in ("upper_arms", "forearms", "gimbal", "helicopter", "rotor_disc", "wind"):
        assert f"  ns: {part}\n" in shown

    ended = [(*flight.communicate(timeout=90), flight.returncode) for flight in (*alone, *beside)]
    assert [code for _, _, code in ended] == [0] * 4, ended
    flights = [json.loads(out) for out, _, _ in ended]
    hashes = [flight["sha256"] for flight in flights]
    assert hashes[:2] == hashes[2:]
    assert hashes[0] != hashes[1]
    assert all(flight["lost_messages"] == 0 for flight in flights)

    for name in ("alone_1", "beside_1"):
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
