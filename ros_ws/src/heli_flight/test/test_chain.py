"""The chain: ratios by hand, segments of excitations, what is said when a block bears no estimate."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from heli_bench_sim import linearize
from heli_bench_sim.parameters import PARAMETER_SETS
from heli_bench_sim.trim import trim
from heli_common.errors import InputError
from heli_common.flight_state import FlightState, flight_state_values
from heli_common.timing import CONTROL_PERIOD_NS
from heli_common.topics import TOPICS
from heli_flight import chain
from heli_flight.chain import KINDS, MODELS, Chain, Hover, excited_segments, identified_blocks
from heli_flight.cli.chain import show
from heli_flight.plan import load_plan
from heli_identification.flight_signals import Channel, FlightSignals
from heli_identification.helicopter_structures import SHAFT_REACTION
from heli_identification.preparation import Segment, with_shaft_held


def chain_with(scale: float, failure: str = "") -> Chain:
    """Two seeds each; the identified model's hovers are `scale` times as wide in x, equal otherwise."""
    hovers = []
    for kind in KINDS:
        for model in MODELS:
            wider = scale if model == "identified" else 1.0
            hovers += [
                Hover(kind, model, seed, (wider * size, 2.0, 3.0, 4.0)) for seed, size in ((1, 1.0), (2, 3.0))
            ]
    if failure:
        hovers.append(Hover(KINDS[0], MODELS[0], 3, (), failure))
    return Chain(Path("m.yaml"), {}, ("vertical: stays",), tuple(hovers))


def test_ratios_by_hand(capsys: pytest.CaptureFixture[str]) -> None:
    found = chain_with(16.0)
    assert found.mean_sigmas("gst2", "linearised") == pytest.approx((2.0, 2.0, 3.0, 4.0))
    assert found.ratios("gst2") == pytest.approx((16.0, 1.0, 1.0, 1.0))
    assert found.ratio("ncf2") == pytest.approx(2.0)  # the fourth root of 16
    assert not found.holds and chain_with(1.4).holds
    show(found, 2)
    told = capsys.readouterr().out
    assert "does not hold" in told and "vertical: stays" in told
    assert json.loads(json.dumps(found.mapping()))["controllers"]["gst2"]["ratio"] == pytest.approx(2.0)


def test_a_hover_that_fails_is_no_success(capsys: pytest.CaptureFixture[str]) -> None:
    found = chain_with(1.0, "too low")
    assert found.ratio("gst2") is None and found.ratio("ncf2") == pytest.approx(1.0)
    assert not found.holds
    show(found, 2)
    assert "gst2 identified seed 3: too low" in capsys.readouterr().out


def record_of(numbers: list[int]) -> SimpleNamespace:
    """What `excited_segments` reads of a flight: the number of the excitation at every control tick."""
    layout = TOPICS["flight_state"].layout
    place = layout.fields.index("effort.flight_state")
    data = []
    for tick, number in enumerate(numbers):
        values = [float(value) for value in flight_state_values(FlightState.FLYING, 163.0)]
        values[place] = float(number)
        data.append(layout.pack(tick * CONTROL_PERIOD_NS, values))
    table = (
        np.arange(len(numbers), dtype=np.int64) * CONTROL_PERIOD_NS,
        np.array([[float(n) if i == place else 0.0 for i in range(len(layout.fields))] for n in numbers]),
    )
    return SimpleNamespace(bag=SimpleNamespace(messages={"flight_state": data}), table=table)


def test_segments_follow_the_plan(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = load_plan("identification")
    record = record_of([0] * 100 + [1] * 300 + [0] * 50 + [2] * 200 + [3] * 100)
    layout = SimpleNamespace(fields=TOPICS["flight_state"].layout.fields, read=lambda _: record.table)
    monkeypatch.setitem(chain.TOPICS, "flight_state", SimpleNamespace(layout=layout))
    found = excited_segments(record, plan, ("A_1s", "B_1s"))  # type: ignore[arg-type]
    assert found == [Segment(1.5, 3.99), Segment(5.0, 6.49)]
    assert excited_segments(record, plan, ("theta_0", "theta_t")) == [Segment(7.0, 7.49)]  # type: ignore[arg-type]
    assert excited_segments(record, plan, ("u", "v")) == []  # type: ignore[arg-type]


def test_a_block_without_data_stays_and_that_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = load_plan("identification")
    estimate = SimpleNamespace(converged=False)
    model = SimpleNamespace(fit=None, estimate=estimate, model=lambda name, prior: (name, prior))

    def only_horizontal(flights: object, choice: chain.Choice) -> SimpleNamespace:
        if choice.structure == "vertical":
            raise InputError("input theta_t is not excited", key="flight")
        return model

    monkeypatch.setattr(chain, "identify", only_horizontal)
    monkeypatch.setattr(chain, "excited_segments", lambda *_: [Segment(0.0, 1.0)])
    found, blocks, remarks = identified_blocks(None, plan, lambda *_: None)  # type: ignore[arg-type]
    assert found == ("identified", None) and list(blocks) == ["horizontal"]
    assert remarks == ("vertical: flight: input theta_t is not excited; stays as the prior model has it",)
    # a search that did not come to its end is no estimate either
    monkeypatch.setattr(chain, "identify", lambda *_: model)
    assert "vertical: explains" in identified_blocks(None, plan, lambda *_: None)[2][0]  # type: ignore[arg-type]


def test_the_yaw_rate_with_the_shaft_held() -> None:
    # the rotor slows down by 2 rad/s and the body turns by what that gives; nothing else acts
    stamps = np.arange(5, dtype=np.int64) * CONTROL_PERIOD_NS
    speed = np.array([163.0, 163.0, 163.0, 162.0, 161.0])
    yaw = SHAFT_REACTION * (speed - 163.0) + 0.01
    signals = FlightSignals("f", {"r": Channel(stamps, yaw), "Omega": Channel(stamps[1:], speed[1:])}, {}, {})
    held = with_shaft_held(signals)["r"]
    assert held.stamps.tolist() == stamps[1:].tolist()
    assert held.values - held.values[0] == pytest.approx(np.zeros(4))
    alone = FlightSignals("f", {"r": Channel(stamps, yaw)}, {}, {})
    assert with_shaft_held(alone) is alone.measured


def test_the_shafts_reaction_is_that_of_the_bench() -> None:
    helicopter = PARAMETER_SETS["thesis"]()
    model = linearize.linearize(helicopter, trim(helicopter))
    torque = model.A[:, model.states.index("M_A")]
    ratio = torque[model.states.index("r")] / torque[model.states.index("Omega")]
    assert ratio == pytest.approx(SHAFT_REACTION, rel=1e-3)
