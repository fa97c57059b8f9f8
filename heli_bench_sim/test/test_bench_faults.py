"""Faults: when they act, and the numbers that show them."""

import math

import pytest

from heli_bench_sim.faults import (
    FAULT_KINDS,
    NO_FAULTS,
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
from heli_common.topics import FAULT_FIELDS

SECOND = 1_000_000_000
ONE_OF_EACH: tuple[Fault, ...] = (
    EncoderStuck(start_ns=0, encoder="arm_3"),
    EncoderLostCounts(start_ns=0, encoder="yaw", counts=-40),
    ImuDropout(start_ns=0),
    ImuBiasJump(start_ns=0, axis="accelerometer_y", size=0.5),
    ServoJam(start_ns=0, servo="tail"),
    SupplySag(start_ns=0, fraction=0.75),
    LinkDelay(start_ns=0, delay_ns=100_000_000),
)


def shown(*faults: Fault) -> dict[str, float]:
    """The numbers of these faults by name, those that are 0 left out."""
    return {name: value for name, value in zip(FAULT_FIELDS, fault_values(faults), strict=True) if value}


def test_a_fault_acts_from_its_start_until_before_its_end() -> None:
    fault = ImuDropout(start_ns=2 * SECOND, end_ns=3 * SECOND)
    assert [fault.acts(stamp) for stamp in (2 * SECOND - 1, 2 * SECOND, 3 * SECOND - 1, 3 * SECOND)] == [
        False,
        True,
        True,
        False,
    ]
    assert ImuDropout(start_ns=0).acts(10**15)


def test_schedule_by_hand() -> None:
    late = ImuDropout(start_ns=5, end_ns=9)
    early = ServoJam(start_ns=1, end_ns=7, servo="1")
    stays = EncoderLostCounts(start_ns=5, encoder="roll", counts=3)
    schedule = FaultSchedule((late, early)).with_fault(stays)
    assert schedule.acting(0) == ()
    assert schedule.acting(1) == (early,)
    assert schedule.acting(5) == (early, late, stays)
    assert schedule.acting(9) == (stays,)
    assert schedule.changes() == (1, 5, 7, 9)
    assert NO_FAULTS.acting(0) == () == NO_FAULTS.changes()


def test_numbers_by_hand() -> None:
    assert [shown(fault) for fault in ONE_OF_EACH] == [
        {"encoder_stuck": 4.0},
        {"encoder_lost_counts": 8.0},
        {"imu_dropout": 1.0},
        {},
        {"servo_jam": 8.0},
        {"supply_sag": 0.25},
        {"link_delay": 0.1},
    ]
    assert shown() == {}
    assert len(fault_values(())) == len(FAULT_FIELDS) == len(set(FAULT_FIELDS))


def test_every_kind_but_a_bias_jump_has_a_number() -> None:
    assert {fault.kind for fault in ONE_OF_EACH} == set(FAULT_KINDS)
    assert {type(fault) for fault in ONE_OF_EACH} == set(FAULT_KINDS.values())
    assert set(shown(*ONE_OF_EACH)) == set(FAULT_FIELDS) == set(FAULT_KINDS) - {"imu_bias_jump"}


def test_several_of_one_kind_join() -> None:
    assert shown(
        EncoderStuck(start_ns=0, encoder="arm_1"),
        EncoderStuck(start_ns=1, encoder="roll"),
        EncoderStuck(start_ns=2, encoder="arm_1"),
        EncoderLostCounts(start_ns=0, encoder="arm_1", counts=5),
        EncoderLostCounts(start_ns=0, encoder="arm_1", counts=-7),
        EncoderLostCounts(start_ns=0, encoder="arm_2", counts=1),
        ImuBiasJump(start_ns=0, axis="gyro_x", size=0.25),
        ImuBiasJump(start_ns=0, axis="gyro_x", size=0.5),
        ServoJam(start_ns=0, servo="1"),
        ServoJam(start_ns=0, servo="3"),
        SupplySag(start_ns=0, fraction=0.5),
        SupplySag(start_ns=0, fraction=0.5),
        LinkDelay(start_ns=0, delay_ns=2_500_000),
        LinkDelay(start_ns=0, delay_ns=5_000_000),
    ) == {
        "encoder_stuck": 33.0,
        "encoder_lost_counts": 3.0,
        "servo_jam": 5.0,
        "supply_sag": 0.75,
        "link_delay": pytest.approx(0.0075),
    }


def test_a_supply_that_gives_nothing_is_seen() -> None:
    assert shown(SupplySag(start_ns=0, fraction=0.0)) == {"supply_sag": 1.0}
    assert all(math.isfinite(value) for value in fault_values(ONE_OF_EACH))
