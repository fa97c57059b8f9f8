"""Faults in words: plans and requests read and written, every mistake named in one line."""

import math

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from heli_bench_sim.fault_request import fault_from_text
from heli_bench_sim.fault_words import fault_schedule, to_mappings
from heli_bench_sim.faults import (
    SERVO_NAMES,
    EncoderLostCounts,
    EncoderStuck,
    Fault,
    ImuBiasJump,
    ImuDropout,
    LinkDelay,
    ServoJam,
    SupplySag,
    fault_values,
)
from heli_common.errors import InputError
from heli_common.rig_geometry import ENCODER_NAMES
from heli_common.topics import IMU_AXES

MS = 1_000_000
DEG = math.pi / 180.0

ALL_KINDS = """\
- {kind: encoder_stuck, encoder: arm_1, at_s: 40.0, for_s: 2.0}
- {kind: encoder_lost_counts, encoder: yaw, counts: -40, at_s: 45}
- {kind: imu_dropout, at_s: 50.0, for_s: 0.5}
- {kind: imu_bias_jump, axis: gyro_z, size_deg_s: 2.0, at_s: 50.0}
- {kind: imu_bias_jump, axis: accelerometer_x, size_m_s2: -0.5, at_s: 0}
- {kind: servo_jam, servo: tail, at_s: 55.0, for_s: 0.0025}
- {kind: servo_jam, servo: 2, at_s: 55.0}
- {kind: supply_sag, voltage_fraction: 0.8, at_s: 57.0, for_s: 1.0}
- {kind: link_delay, delay_s: 0.1, at_s: 60.0}
"""


def test_all_kinds_by_hand() -> None:
    assert fault_schedule(yaml.safe_load(ALL_KINDS)).faults == (
        EncoderStuck(start_ns=40_000 * MS, end_ns=42_000 * MS, encoder="arm_1"),
        EncoderLostCounts(start_ns=45_000 * MS, encoder="yaw", counts=-40),
        ImuDropout(start_ns=50_000 * MS, end_ns=50_500 * MS),
        ImuBiasJump(start_ns=50_000 * MS, axis="gyro_z", size=2.0 * DEG),
        ImuBiasJump(start_ns=0, axis="accelerometer_x", size=-0.5),
        ServoJam(start_ns=55_000 * MS, end_ns=55_002_500_000, servo="tail"),
        ServoJam(start_ns=55_000 * MS, servo="2"),
        SupplySag(start_ns=57_000 * MS, end_ns=58_000 * MS, fraction=0.8),
        LinkDelay(start_ns=60_000 * MS, delay_ns=100 * MS),
    )


def test_written_as_it_was_read() -> None:
    entries = yaml.safe_load(ALL_KINDS)
    assert to_mappings(fault_schedule(entries).faults) == entries
    assert fault_schedule([]).faults == ()


@pytest.mark.parametrize(
    ("given_s", "samples"), [(0.0025, 1), (0.003749, 1), (0.00375, 2), (0.1, 40), (0.1012, 40), (1.0, 400)]
)
def test_a_delay_is_rounded_to_whole_samples_halves_up(given_s: float, samples: int) -> None:
    (fault,) = fault_schedule([{"kind": "link_delay", "delay_s": given_s, "at_s": 1.0}]).faults
    assert fault == LinkDelay(start_ns=1000 * MS, delay_ns=samples * 2_500_000)


def test_requests_by_hand() -> None:
    now = 12_340 * MS
    assert fault_from_text("encoder_stuck encoder=arm_1 for_s=2", now_ns=now) == EncoderStuck(
        start_ns=now, end_ns=now + 2000 * MS, encoder="arm_1"
    )
    assert fault_from_text("  imu_dropout ", now_ns=now) == ImuDropout(start_ns=now)
    assert fault_from_text("servo_jam servo=1", now_ns=-2_500_000) == ServoJam(start_ns=0, servo="1")
    jump = fault_from_text("imu_bias_jump size_deg_s=-1.5e1 axis=gyro_x", now_ns=now)
    assert jump == ImuBiasJump(start_ns=now, axis="gyro_x", size=math.radians(-15.0))
    lost = fault_from_text("encoder_lost_counts encoder=pitch counts=12", now_ns=now)
    assert lost == EncoderLostCounts(start_ns=now, encoder="pitch", counts=12)


KINDS = "encoder_stuck, encoder_lost_counts, imu_dropout, imu_bias_jump, servo_jam, supply_sag, link_delay"
MISTAKES = [
    ("{}", "faults[0].kind: is missing", KINDS),
    ("{kind: gremlin, at_s: 1}", "faults[0].kind: 'gremlin' is unknown", KINDS),
    ("{kind: [imu_dropout], at_s: 1}", "faults[0].kind: ['imu_dropout'] is unknown", KINDS),
    ("imu_dropout", "faults[0]: 'imu_dropout' is no fault", "- {kind: encoder_stuck"),
    ("{kind: imu_dropout}", "faults[0].at_s: is missing", "0 .. 86400 s"),
    ("{kind: imu_dropout, at_s: -1}", "faults[0].at_s: -1 is out of range", "0 .. 86400 s"),
    ("{kind: imu_dropout, at_s: .nan}", "faults[0].at_s: nan is out of range", "0 .. 86400 s"),
    ("{kind: imu_dropout, at_s: true}", "faults[0].at_s: True is not a number", "0 .. 86400 s"),
    ("{kind: imu_dropout, at_s: soon}", "faults[0].at_s: 'soon' is not a number", "0 .. 86400 s"),
    ("{kind: imu_dropout, at_s: 1, for_s: 0}", "faults[0].for_s: 0 is out of range", "0.0025 .. 86400 s"),
    ("{kind: imu_dropout, at_s: 1, for_s: .inf}", "faults[0].for_s: inf is out", "0.0025 .. 86400 s"),
    ("{kind: imu_dropout, at_s: 1, for_s: }", "faults[0].for_s: None is not a", "0.0025 .. 86400 s"),
    ("{kind: imu_dropout, at_s: 1, for: 2}", "faults[0].for: unknown key", "kind, at_s, for_s"),
    ("{kind: imu_dropout, at_s: 1, 5: 2}", "faults[0].5: unknown key", "kind, at_s, for_s"),
    ("{kind: encoder_stuck, at_s: 1}", "faults[0].encoder: is missing", "arm_1, arm_2, arm_3, yaw, pitch"),
    ("{kind: encoder_stuck, encoder: arm_4, at_s: 1}", "faults[0].encoder: 'arm_4' is unknown", "arm_1, "),
    ("{kind: encoder_stuck, encoder: 1, at_s: 1}", "faults[0].encoder: 1 is unknown", "arm_1, "),
    ("{kind: encoder_lost_counts, encoder: yaw, at_s: 1}", "faults[0].counts: is missing", "not 0"),
    (
        "{kind: encoder_lost_counts, encoder: yaw, counts: 0, at_s: 1}",
        "faults[0].counts: 0 is not allowed",
        "an integer -2000 .. 2000, not 0",
    ),
    ("{kind: encoder_lost_counts, encoder: yaw, counts: 2001, at_s: 1}", "counts: 2001 is not", "2000"),
    ("{kind: encoder_lost_counts, encoder: yaw, counts: 1.5, at_s: 1}", "counts: 1.5 is not", "an integer"),
    ("{kind: encoder_lost_counts, encoder: yaw, counts: true, at_s: 1}", "counts: True is not", "an integer"),
    (
        "{kind: encoder_lost_counts, encoder: yaw, counts: 5, at_s: 1, for_s: 2}",
        "faults[0].for_s: unknown key",
        "kind, encoder, counts, at_s",
    ),
    ("{kind: imu_bias_jump, size_deg_s: 1, at_s: 1}", "faults[0].axis: is missing", "gyro_x, gyro_y"),
    ("{kind: imu_bias_jump, axis: gyro, size_deg_s: 1, at_s: 1}", "axis: 'gyro' is unknown", "gyro_x, "),
    ("{kind: imu_bias_jump, axis: gyro_x, at_s: 1}", "faults[0].size_deg_s: is missing", "-300 .. 300 deg/s"),
    (
        "{kind: imu_bias_jump, axis: gyro_x, size_m_s2: 1, at_s: 1}",
        "faults[0].size_deg_s: is missing",
        "-300 .. 300 deg/s",
    ),
    (
        "{kind: imu_bias_jump, axis: accelerometer_x, size_m_s2: 1, size_deg_s: 1, at_s: 1}",
        "faults[0].size_deg_s: unknown key",
        "kind, axis, size_m_s2, at_s, for_s",
    ),
    (
        "{kind: imu_bias_jump, axis: gyro_x, size_deg_s: -0.0001, at_s: 1}",
        "faults[0].size_deg_s: -0.0001 is too small",
        "at least 0.001 deg/s in size",
    ),
    ("{kind: imu_bias_jump, axis: gyro_x, size_deg_s: 301, at_s: 1}", "size_deg_s: 301 is out", "300 deg/s"),
    ("{kind: servo_jam, at_s: 1}", "faults[0].servo: is missing", "1, 2, 3, tail"),
    ("{kind: servo_jam, servo: 4, at_s: 1}", "faults[0].servo: 4 is unknown", "1, 2, 3, tail"),
    ("{kind: servo_jam, servo: 1.0, at_s: 1}", "faults[0].servo: 1.0 is unknown", "1, 2, 3, tail"),
    ("{kind: servo_jam, servo: true, at_s: 1}", "faults[0].servo: True is unknown", "1, 2, 3, tail"),
    ("{kind: supply_sag, at_s: 1}", "faults[0].voltage_fraction: is missing", "0 .. 0.99"),
    ("{kind: supply_sag, voltage_fraction: 1, at_s: 1}", "voltage_fraction: 1 is out of range", "0 .. 0.99"),
    ("{kind: link_delay, at_s: 1}", "faults[0].delay_s: is missing", "0.0025 .. 1 s"),
    ("{kind: link_delay, delay_s: 0, at_s: 1}", "faults[0].delay_s: 0 is out of range", "0.0025 .. 1 s"),
    ("{kind: link_delay, delay_s: 1.1, at_s: 1}", "faults[0].delay_s: 1.1 is out of range", "0.0025 .. 1 s"),
]


@pytest.mark.parametrize(("entry", "problem", "allowed"), MISTAKES)
def test_a_mistake_is_named(entry: str, problem: str, allowed: str) -> None:
    with pytest.raises(InputError) as caught:
        fault_schedule([yaml.safe_load(entry)], file="my.yaml")
    message = str(caught.value)
    assert message.startswith("my.yaml: faults[0]") and "\n" not in message
    assert problem in message and allowed in message.partition("(allowed: ")[2]


@pytest.mark.parametrize("entries", [None, 5, "imu_dropout", {"kind": "imu_dropout", "at_s": 1}])
def test_what_is_no_list(entries: object) -> None:
    with pytest.raises(InputError, match=r"^my\.yaml: faults: .* is no list of faults \(allowed: - \{kind"):
        fault_schedule(entries, file="my.yaml")


def test_the_wrong_one_of_several_is_named() -> None:
    entries = [{"kind": "imu_dropout", "at_s": 1.0}, {"kind": "imu_dropout", "at_s": "x"}]
    with pytest.raises(InputError, match=r"^old\.yaml: plan\.faults\[1\]\.at_s: 'x'"):
        fault_schedule(entries, file="old.yaml", key="plan.faults")


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "fault.kind: '' is unknown"),
        ("gremlin", "fault.kind: 'gremlin' is unknown"),
        ("encoder_stuck", "fault.encoder: is missing"),
        ("encoder_stuck arm_1", "fault: 'arm_1' is no setting"),
        ("encoder_stuck encoder=", "fault: 'encoder=' is no setting"),
        ("encoder_stuck =arm_1", "fault: '=arm_1' is no setting"),
        ("encoder_stuck encoder=arm_1 encoder=arm_2", "fault.encoder: stands twice"),
        ("imu_dropout kind=servo_jam", "fault.kind: stands twice"),
        ("imu_dropout at_s=5", "fault.at_s: unknown key"),
        ("imu_dropout for_s=nan", "fault.for_s: nan is out of range"),
        ("imu_dropout for_s=1e999", "fault.for_s: inf is out of range"),
        ("imu_dropout for_s=long", "fault.for_s: 'long' is not a number"),
        ("encoder_lost_counts encoder=yaw counts=1.0", "fault.counts: 1.0 is not allowed"),
        ("imu_dropout for_s=" + 200 * "9", "fault: 218 characters are no fault"),
    ],
)
def test_a_wrong_request_is_named(text: str, problem: str) -> None:
    with pytest.raises(InputError) as caught:
        fault_from_text(text, now_ns=0)
    message = str(caught.value)
    assert message.startswith(problem) and "(allowed: " in message and "\n" not in message


def entry(kind: str, **settings: st.SearchStrategy[object]) -> st.SearchStrategy[dict[str, object]]:
    needed = {"kind": st.just(kind), **settings, "at_s": st.floats(0.0, 86400.0)}
    return st.fixed_dictionaries(needed, optional={"for_s": st.floats(0.0025, 86400.0)})


def jump(axes: tuple[str, ...], key: str, most: float) -> st.SearchStrategy[dict[str, object]]:
    size = st.floats(-most, most).filter(lambda value: abs(value) >= 0.001)
    return entry("imu_bias_jump", axis=st.sampled_from(axes), **{key: size})


ENCODER = st.sampled_from(ENCODER_NAMES)
ENTRIES = st.one_of(
    entry("encoder_stuck", encoder=ENCODER),
    st.fixed_dictionaries(
        {
            "kind": st.just("encoder_lost_counts"),
            "encoder": ENCODER,
            "counts": st.integers(-2000, 2000).filter(bool),
            "at_s": st.floats(0.0, 86400.0),
        }
    ),
    entry("imu_dropout"),
    jump(IMU_AXES[:3], "size_deg_s", 300.0),
    jump(IMU_AXES[3:], "size_m_s2", 49.0),
    entry("servo_jam", servo=st.sampled_from([1, 2, 3, *SERVO_NAMES])),
    entry("supply_sag", voltage_fraction=st.floats(0.0, 0.99)),
    entry("link_delay", delay_s=st.floats(0.0025, 1.0)),
)


@given(st.lists(ENTRIES, max_size=5))
def test_round_trip(entries: list[dict[str, object]]) -> None:
    """Faults come back equal from what is written of them, also through YAML, and are written the same."""
    faults = fault_schedule(entries).faults
    written = to_mappings(faults)
    assert fault_schedule(yaml.safe_load(yaml.safe_dump(written))).faults == faults
    assert to_mappings(fault_schedule(written).faults) == written


@given(ENTRIES)
def test_what_is_read_lies_within_what_was_written(entry: dict[str, object]) -> None:
    """Starts and ends are right to the nanosecond, at least one sample is hit, and ground truth shows it."""
    (fault,) = fault_schedule([entry]).faults
    start, duration = entry["at_s"], entry.get("for_s")
    assert isinstance(start, float)
    assert abs(fault.start_ns - start * 1e9) <= 0.6
    if isinstance(duration, float) and fault.end_ns is not None:
        assert abs(fault.end_ns - fault.start_ns - duration * 1e9) <= 0.6
    else:
        assert fault.end_ns is None and duration is None
    first = -(-fault.start_ns // 2_500_000) * 2_500_000
    assert fault.acts(first)
    shown = sum(value != 0.0 for value in fault_values([fault]))
    assert shown == (0 if isinstance(fault, ImuBiasJump) else 1)


@given(ENTRIES, st.integers(0, 10**14))
def test_a_request_is_a_plan_entry_that_begins_now(entry: dict[str, object], now_ns: int) -> None:
    (planned,) = fault_schedule([entry]).faults
    own = " ".join(f"{key}={value!r}" for key, value in entry.items() if key not in ("kind", "at_s"))
    asked = fault_from_text(f"{entry['kind']} {own}".replace("'", ""), now_ns=now_ns)
    assert same_but_for_time(planned) == same_but_for_time(asked)
    assert asked.start_ns == now_ns
    assert (asked.end_ns is None) == (planned.end_ns is None)
    if asked.end_ns is not None and planned.end_ns is not None:
        assert asked.end_ns - asked.start_ns == planned.end_ns - planned.start_ns


def same_but_for_time(fault: Fault) -> dict[str, object]:
    return {key: value for key, value in to_mappings([fault])[0].items() if key not in ("at_s", "for_s")}
