"""Faults in words: the list of mappings in a plan, read and written.

```yaml
faults:
  - {kind: encoder_stuck, encoder: arm_1, at_s: 40.0, for_s: 2.0}
  - {kind: encoder_lost_counts, encoder: yaw, counts: -40, at_s: 45.0}
  - {kind: imu_dropout, at_s: 50.0, for_s: 0.5}
  - {kind: imu_bias_jump, axis: gyro_z, size_deg_s: 2.0, at_s: 50.0}
  - {kind: imu_bias_jump, axis: accelerometer_x, size_m_s2: 0.5, at_s: 50.0}
  - {kind: servo_jam, servo: tail, at_s: 55.0, for_s: 0.2}
  - {kind: supply_sag, voltage_fraction: 0.8, at_s: 57.0, for_s: 1.0}
  - {kind: link_delay, delay_s: 0.1, at_s: 60.0}
```

`at_s` is flight time, `for_s` a duration of at least one sample (2.5 ms); without it the fault stays. Lost
counts take no `for_s`: they stay lost. A delay is rounded to the nearest whole sample, halves up.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from heli_bench_sim.faults import (
    FAULT_KINDS,
    SERVO_NAMES,
    EncoderLostCounts,
    EncoderStuck,
    Fault,
    FaultSchedule,
    ImuBiasJump,
    LinkDelay,
    ServoJam,
    SupplySag,
)
from heli_common.errors import InputError
from heli_common.quantities import Quantity, check_number, degrees_of
from heli_common.rig_geometry import ENCODER_NAMES
from heli_common.timing import SENSOR_PERIOD_NS
from heli_common.topics import IMU_AXES

_DAY, _SAMPLE = 86400.0, SENSOR_PERIOD_NS / 1e9
_START = Quantity("s", "D", "start, flight time", 0.0, _DAY)
_LASTING = Quantity("s", "D", "duration", _SAMPLE, _DAY)
_MOST_COUNTS = 2000
_FRACTION = Quantity("", "D", "of the voltage that is left", 0.0, 0.99)
_DELAY = Quantity("s", "D", "additional dead time", _SAMPLE, 1.0)
_RATE = Quantity("deg/s", "D", "jump of a gyro's bias", -300.0, 300.0)
_ACCELERATION = Quantity("m/s2", "D", "jump of an accelerometer's bias", -49.0, 49.0)
_SMALLEST_JUMP = 0.001

_EXAMPLE = "- {kind: encoder_stuck, encoder: arm_1, at_s: 12.0, for_s: 2.0}"


def fault_schedule(entries: object, *, file: str | None = None, key: str = "faults") -> FaultSchedule:
    """The schedule that a list of mappings describes.

    Args:
        entries: as YAML gives them.
        file: they stand in, for errors.
        key: they stand under, for errors.

    Raises:
        InputError: names file, key, value and what is allowed.
    """
    if not isinstance(entries, list):
        raise InputError(f"{entries!r} is no list of faults", allowed=_EXAMPLE, file=file, key=key)
    faults = (read_fault(entry, file=file, key=f"{key}[{index}]") for index, entry in enumerate(entries))
    return FaultSchedule(tuple(faults))


def read_fault(settings: object, *, file: str | None, key: str, now_ns: int | None = None) -> Fault:
    """The fault that a mapping describes.

    Args:
        settings: kind and keys of the fault.
        file: they stand in, for errors.
        key: they stand under, for errors.
        now_ns: stamp of its start [ns]; without it the settings tell, under `at_s`.

    Raises:
        InputError: names file, key, value and what is allowed.
    """
    if not isinstance(settings, Mapping):
        raise InputError(f"{settings!r} is no fault", allowed=_EXAMPLE, file=file, key=key)
    entry = _Entry(settings, file, key)
    kind = FAULT_KINDS[entry.word("kind", tuple(FAULT_KINDS))]
    own = _own_settings(kind, entry)
    start_ns = _nanoseconds(entry.number("at_s", _START)) if now_ns is None else now_ns
    end_ns = None
    if kind is not EncoderLostCounts and entry.has("for_s"):
        end_ns = start_ns + _nanoseconds(entry.number("for_s", _LASTING))
    entry.refuse_the_rest()
    return kind(start_ns=start_ns, end_ns=end_ns, **own)


def to_mappings(faults: Iterable[Fault]) -> list[dict[str, object]]:
    """Faults as a plan writes them; `fault_schedule` gives equal ones back.

    Args:
        faults: of any kinds.
    """
    return [_mapping(fault) for fault in faults]


class _Entry:
    """The settings of one fault, where they stand, and which keys have been asked for."""

    def __init__(self, settings: Mapping[Any, object], file: str | None, place: str) -> None:
        self._settings, self._file, self._place = settings, file, place
        self._known: list[str] = []

    def has(self, key: str) -> bool:
        self._known.append(key)
        return key in self._settings

    def word(self, key: str, words: Sequence[str]) -> str:
        value = self._given(key, ", ".join(words))
        if str(value) not in words:
            raise self._error(key, f"{value!r} is unknown", ", ".join(words))
        return str(value)

    def number(self, key: str, about: Quantity, smallest: float = 0.0) -> float:
        """A number in its range and at least `smallest` in size."""
        value = self._given(key, f"{about.minimum:g} .. {about.maximum:g} {about.unit}".strip())
        number = check_number(value, about, file=self._file, key=f"{self._place}.{key}")
        if abs(number) < smallest:
            allowed = f"at least {smallest:g} {about.unit} in size"
            raise self._error(key, f"{value!r} is too small", allowed)
        return number

    def whole(self, key: str, most: int) -> int:
        """An integer of a size of 1 to `most`."""
        allowed = f"an integer {-most} .. {most}, not 0"
        value = self._given(key, allowed)
        if isinstance(value, bool) or not isinstance(value, int) or not 0 < abs(value) <= most:
            raise self._error(key, f"{value!r} is not allowed", allowed)
        return value

    def refuse_the_rest(self) -> None:
        """Refuse keys that nobody has asked for."""
        for key in self._settings:
            if key not in self._known:
                raise self._error(str(key), "unknown key", ", ".join(self._known))

    def _given(self, key: str, allowed: str) -> object:
        if not self.has(key):
            raise self._error(key, "is missing", allowed)
        return self._settings[key]

    def _error(self, key: str, problem: str, allowed: str) -> InputError:
        return InputError(problem, allowed=allowed, file=self._file, key=f"{self._place}.{key}")


def _own_settings(kind: type[Fault], entry: _Entry) -> dict[str, Any]:
    """What a kind has beside start and end, in SI."""
    own: dict[str, Any] = {}
    if kind in (EncoderStuck, EncoderLostCounts):
        own["encoder"] = entry.word("encoder", ENCODER_NAMES)
    if kind is EncoderLostCounts:
        own["counts"] = entry.whole("counts", _MOST_COUNTS)
    if kind is ImuBiasJump:
        own["axis"] = entry.word("axis", IMU_AXES)
        if _turns(own["axis"]):
            own["size"] = math.radians(entry.number("size_deg_s", _RATE, _SMALLEST_JUMP))
        else:
            own["size"] = entry.number("size_m_s2", _ACCELERATION, _SMALLEST_JUMP)
    if kind is ServoJam:
        own["servo"] = entry.word("servo", SERVO_NAMES)
    if kind is SupplySag:
        own["fraction"] = entry.number("voltage_fraction", _FRACTION)
    if kind is LinkDelay:
        samples = math.floor(_nanoseconds(entry.number("delay_s", _DELAY)) / SENSOR_PERIOD_NS + 0.5)
        own["delay_ns"] = samples * SENSOR_PERIOD_NS
    return own


def _mapping(fault: Fault) -> dict[str, object]:
    settings: dict[str, object] = {"kind": fault.kind}
    match fault:
        case EncoderStuck():
            settings["encoder"] = fault.encoder
        case EncoderLostCounts():
            settings |= {"encoder": fault.encoder, "counts": fault.counts}
        case ImuBiasJump() if _turns(fault.axis):
            settings |= {"axis": fault.axis, "size_deg_s": degrees_of(fault.size)}
        case ImuBiasJump():
            settings |= {"axis": fault.axis, "size_m_s2": fault.size}
        case ServoJam():
            settings["servo"] = int(fault.servo) if fault.servo.isdigit() else fault.servo
        case SupplySag():
            settings["voltage_fraction"] = fault.fraction
        case LinkDelay():
            settings["delay_s"] = _seconds(fault.delay_ns)
    settings["at_s"] = _seconds(fault.start_ns)
    if fault.end_ns is not None:
        settings["for_s"] = _seconds(fault.end_ns - fault.start_ns)
    return settings


def _turns(axis: str) -> bool:
    return axis.startswith("gyro")


def _nanoseconds(seconds: float) -> int:
    return round(seconds * 1e9)


def _seconds(nanoseconds: int) -> float:
    return nanoseconds / 1e9
