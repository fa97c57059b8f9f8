"""What faults do, by hand and in any order of overlapping."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_bench_sim.fault_effects import FaultEffects
from heli_bench_sim.faults import (
    EncoderLostCounts,
    EncoderStuck,
    Fault,
    FaultSchedule,
    ImuBiasJump,
    ImuDropout,
    LinkDelay,
    ServoJam,
    SupplySag,
    fault_values,
)
from heli_common.rig_geometry import ENCODER_NAMES
from heli_common.topics import FAULT_FIELDS

SAMPLE = 2_500_000


def effects(*faults: Fault) -> FaultEffects:
    return FaultEffects(FaultSchedule(faults))


def said_counts(faults: FaultEffects, samples: int, encoder: int) -> list[int]:
    """What one encoder says while its true count is ten times the number of the sample."""
    said = []
    for sample in range(samples):
        true = np.full(6, 10 * sample, dtype=np.int64)
        said.append(int(faults.counts(sample * SAMPLE, true)[encoder]))
        assert (true == 10 * sample).all()
    return said


def test_nothing_is_wrong_without_faults() -> None:
    faults = FaultEffects()
    counts, indexed, shafts = np.arange(6), np.ones(6, dtype=np.bool_), np.zeros(4)
    assert not faults.any and faults.quiet(0)
    assert faults.counts(0, counts) is counts
    assert faults.indexed(0, indexed) is indexed
    assert faults.shafts(0, shafts) is shafts
    assert faults.bias_jump(0).tolist() == [0.0] * 6
    assert faults.imu_valid(0)
    assert faults.voltage(0, 12.0) == 12.0
    assert faults.link_delay_ns(0) == 0
    assert faults.values(0) == (0.0,) * len(FAULT_FIELDS)


def test_a_stuck_encoder_holds_its_count_and_counts_on_afterwards() -> None:
    faults = effects(EncoderStuck(start_ns=2 * SAMPLE, end_ns=5 * SAMPLE, encoder="arm_2"))
    assert said_counts(faults, 7, 1) == [0, 10, 20, 20, 20, 50, 60]
    assert said_counts(effects(*faults.schedule.faults), 7, 0) == [0, 10, 20, 30, 40, 50, 60]


def test_lost_counts_stay_lost() -> None:
    faults = effects(
        EncoderLostCounts(start_ns=2 * SAMPLE, encoder="yaw", counts=-7),
        EncoderLostCounts(start_ns=4 * SAMPLE, encoder="yaw", counts=100),
    )
    assert said_counts(faults, 6, 3) == [0, 10, 13, 23, 133, 143]


def test_counts_lost_while_stuck_show_when_it_is_free() -> None:
    faults = effects(
        EncoderStuck(start_ns=1 * SAMPLE, end_ns=4 * SAMPLE, encoder="roll"),
        EncoderLostCounts(start_ns=2 * SAMPLE, encoder="roll", counts=5),
    )
    assert said_counts(faults, 6, 5) == [0, 10, 10, 10, 45, 55]


def test_stuck_again_while_stuck_holds_what_was_said() -> None:
    first = EncoderStuck(start_ns=1 * SAMPLE, end_ns=3 * SAMPLE, encoder="arm_1")
    second = EncoderStuck(start_ns=2 * SAMPLE, end_ns=5 * SAMPLE, encoder="arm_1")
    for order in ((first, second), (second, first)):
        assert said_counts(effects(*order), 6, 0) == [0, 10, 10, 10, 10, 50]
    after = EncoderStuck(start_ns=3 * SAMPLE, end_ns=5 * SAMPLE, encoder="arm_1")
    assert said_counts(effects(first, after), 6, 0) == [0, 10, 10, 30, 30, 50]


def test_a_stuck_encoder_sees_no_index() -> None:
    faults = effects(EncoderStuck(start_ns=SAMPLE, end_ns=3 * SAMPLE, encoder="pitch"))
    before, after = np.zeros(6, dtype=np.bool_), np.ones(6, dtype=np.bool_)
    assert not faults.indexed(0, before).any()
    assert not faults.indexed(SAMPLE, before).any()
    assert faults.indexed(2 * SAMPLE, after).tolist() == [True, True, True, True, False, True]
    assert faults.indexed(3 * SAMPLE, after).all()
    assert after.all()


def test_imu() -> None:
    faults = effects(
        ImuDropout(start_ns=SAMPLE, end_ns=2 * SAMPLE),
        ImuBiasJump(start_ns=SAMPLE, end_ns=3 * SAMPLE, axis="gyro_z", size=0.25),
        ImuBiasJump(start_ns=2 * SAMPLE, axis="gyro_z", size=0.5),
        ImuBiasJump(start_ns=2 * SAMPLE, axis="accelerometer_x", size=-1.0),
    )
    assert [faults.imu_valid(sample * SAMPLE) for sample in range(4)] == [True, False, True, True]
    faults = effects(*faults.schedule.faults)
    assert [faults.bias_jump(sample * SAMPLE).tolist() for sample in range(4)] == [
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.25, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.75, -1.0, 0.0, 0.0],
        [0.0, 0.0, 0.5, -1.0, 0.0, 0.0],
    ]
    with pytest.raises(ValueError, match="read-only"):
        faults.bias_jump(3 * SAMPLE)[0] = 1.0


def test_a_jammed_shaft_holds_its_command() -> None:
    faults = effects(ServoJam(start_ns=SAMPLE, end_ns=3 * SAMPLE, servo="2"))
    gone = []
    for sample in range(4):
        commanded = np.full(4, 0.1 * sample)
        gone.append(faults.shafts(sample * SAMPLE, commanded).tolist())
        assert (commanded == 0.1 * sample).all()
    assert gone == [[0.0] * 4, [0.1] * 4, [0.2, 0.1, 0.2, 0.2], [0.1 * 3] * 4]


@pytest.mark.parametrize(
    ("asked", "given_voltage"), [(5.0, 3.0), (12.0, 6.0), (10.0, 6.0), (-1.0, 0.0), (0.0, 0.0)]
)
def test_a_sagging_supply(asked: float, given_voltage: float) -> None:
    """Limited to 0 .. 10 V first, then the fraction."""
    faults = effects(SupplySag(start_ns=SAMPLE, end_ns=2 * SAMPLE, fraction=0.6))
    assert faults.voltage(0, asked) == asked
    assert faults.voltage(SAMPLE, asked) == pytest.approx(given_voltage)
    assert faults.voltage(2 * SAMPLE, asked) == asked


def test_fractions_multiply_and_delays_add() -> None:
    faults = effects(
        SupplySag(start_ns=0, fraction=0.5),
        SupplySag(start_ns=0, fraction=0.5),
        LinkDelay(start_ns=0, delay_ns=SAMPLE),
        LinkDelay(start_ns=SAMPLE, end_ns=2 * SAMPLE, delay_ns=2 * SAMPLE),
    )
    assert faults.voltage(0, 8.0) == 2.0
    assert [faults.link_delay_ns(sample * SAMPLE) for sample in range(3)] == [SAMPLE, 3 * SAMPLE, SAMPLE]


def test_a_fault_added_while_flying() -> None:
    faults = effects()
    assert faults.quiet(SAMPLE) and not effects().any
    faults.add(ImuDropout(start_ns=3 * SAMPLE, end_ns=4 * SAMPLE))
    assert faults.any
    assert [faults.imu_valid(sample * SAMPLE) for sample in (2, 3)] == [True, False]
    faults.add(ServoJam(start_ns=0, servo="tail"))
    assert faults.shafts(3 * SAMPLE, np.full(4, 0.5))[3] == 0.5
    assert faults.shafts(4 * SAMPLE, np.full(4, 0.7)).tolist() == [0.7, 0.7, 0.7, 0.5]
    assert [fault.kind for fault in faults.schedule.faults] == ["imu_dropout", "servo_jam"]


def fault(draw: st.DrawFn) -> Fault:
    start = draw(st.integers(0, 20)) * SAMPLE
    end = draw(st.none() | st.integers(1, 10).map(lambda samples: start + samples * SAMPLE))
    encoder = draw(st.sampled_from(ENCODER_NAMES[:2]))
    return draw(
        st.sampled_from(
            [
                EncoderStuck(start_ns=start, end_ns=end, encoder=encoder),
                EncoderLostCounts(start_ns=start, encoder=encoder, counts=7),
                ImuDropout(start_ns=start, end_ns=end),
                ImuBiasJump(start_ns=start, end_ns=end, axis="gyro_y", size=0.125),
                ServoJam(start_ns=start, end_ns=end, servo="3"),
                SupplySag(start_ns=start, end_ns=end, fraction=0.5),
                LinkDelay(start_ns=start, end_ns=end, delay_ns=2 * SAMPLE),
            ]
        )
    )


FAULTS = st.lists(st.composite(fault)(), max_size=6).map(tuple)


@settings(deadline=None, max_examples=100)
@given(FAULTS)
def test_effects_are_exactly_what_ground_truth_shows(faults: tuple[Fault, ...]) -> None:
    """At every sample the published numbers, those of the schedule and the effects tell the same."""
    acting, schedule = FaultEffects(FaultSchedule(faults)), FaultSchedule(faults)
    previous = [0] * 6
    for sample in range(32):
        stamp = sample * SAMPLE
        values = acting.values(stamp)
        assert values == fault_values(schedule.acting(stamp))
        shown = dict(zip(FAULT_FIELDS, values, strict=True))
        assert acting.quiet(stamp) == (not any(values) and not acting.bias_jump(stamp).any())
        true = np.full(6, 10 * sample, dtype=np.int64)
        said = acting.counts(stamp, true)
        for index, name in enumerate(ENCODER_NAMES):
            if int(shown["encoder_stuck"]) & 1 << index:
                before = schedule.acting(stamp - SAMPLE)
                if any(isinstance(fault, EncoderStuck) and fault.index == index for fault in before):
                    still = {f for f in before if isinstance(f, EncoderStuck) and f.index == index}
                    if still & set(schedule.acting(stamp)):
                        assert said[index] == previous[index]
            else:
                mine = int(shown["encoder_lost_counts"]) >> index & 1
                assert mine == any(
                    f.encoder == name for f in schedule.acting(stamp) if isinstance(f, EncoderLostCounts)
                )
                assert said[index] == 10 * sample + mine * sum(
                    f.counts
                    for f in schedule.acting(stamp)
                    if isinstance(f, EncoderLostCounts) and f.encoder == name
                )
        previous = said.tolist()
        jumps = sum(isinstance(fault, ImuBiasJump) for fault in schedule.acting(stamp))
        assert acting.bias_jump(stamp)[1] == 0.125 * jumps
        assert acting.imu_valid(stamp) == (shown["imu_dropout"] == 0.0)
        assert acting.voltage(stamp, 8.0) == pytest.approx(8.0 * (1.0 - shown["supply_sag"]))
        assert acting.link_delay_ns(stamp) == round(shown["link_delay"] * 1e9)
        moved = acting.shafts(stamp, np.full(4, float(sample)))
        assert moved[[0, 1, 3]].tolist() == [sample] * 3
        if shown["servo_jam"] == 0.0:
            assert moved[2] == sample


@settings(deadline=None, max_examples=100)
@given(FAULTS, st.integers(0, 6))
def test_known_beforehand_or_added_before_its_start_is_the_same(
    faults: tuple[Fault, ...], known: int
) -> None:
    whole = FaultEffects(FaultSchedule(faults))
    bits = FaultEffects(FaultSchedule(faults[:known]))
    waiting = list(faults[known:])
    for sample in range(32):
        stamp = sample * SAMPLE
        for fault in [fault for fault in waiting if fault.start_ns <= stamp]:
            bits.add(fault)
            waiting.remove(fault)
        counts, shafts = np.full(6, 10 * sample, dtype=np.int64), np.full(4, math.sqrt(sample))
        assert bits.counts(stamp, counts).tolist() == whole.counts(stamp, counts).tolist()
        assert bits.shafts(stamp, shafts).tolist() == whole.shafts(stamp, shafts).tolist()
        assert bits.voltage(stamp, 5.0) == whole.voltage(stamp, 5.0)
        assert bits.values(stamp) == whole.values(stamp)
