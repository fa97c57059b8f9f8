"""Excitations in words: the mapping in a plan and in a request, read and written.

```yaml
{signal: prbs, channel: B_1s, amplitude_deg: 0.5, band_rad_s: [0.5, 12], duration: 60.0}
{signal: multisine, channels: [B_1s, A_1s], amplitude_deg: 0.5, band_rad_s: [0.5, 15], duration: 60, seed: 2}
{signal: doublets, channel: u, amplitude_m_s: 0.1, hold: 1.5, duration: 20.0}
```

Amplitudes are peaks: `amplitude_deg` of the commands B_1s, A_1s, theta_0, theta_t, `amplitude_m_s` of the
references u, v, w, `amplitude_deg_s` of r, `amplitude_V` of the motor's control voltage. steps, ramps,
doublets and 3-2-1-1 have a `hold` time; chirp, prbs, noise and multisine a band. `fade` (1 s) and `seed` (1)
may be left out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import radians

import yaml

from heli_common.errors import InputError
from heli_common.quantities import Quantity, check_number, degrees_of
from heli_common.timing import CONTROL_PERIOD
from heli_identification import excitation_signals as signals
from heli_identification.excitation import BANDED, CHANNELS, HELD, SIGNALS, TOGETHER, Excitation

LONGEST_REQUEST = 400
"""Characters of a request; a longer one is refused."""

_SMALLEST, _DEG, _M_S, _DEG_S, _V = 0.001, "amplitude_deg", "amplitude_m_s", "amplitude_deg_s", "amplitude_V"
_PEAKS: dict[str, tuple[str, Quantity]] = {
    "B_1s": (_DEG, Quantity("deg", "D", "peak of longitudinal cyclic", _SMALLEST, 6.0)),
    "A_1s": (_DEG, Quantity("deg", "D", "peak of lateral cyclic", _SMALLEST, 3.0)),
    "theta_0": (_DEG, Quantity("deg", "D", "peak of collective", _SMALLEST, 1.5)),
    "theta_t": (_DEG, Quantity("deg", "D", "peak of tail collective", _SMALLEST, 5.0)),
    "u": (_M_S, Quantity("m/s", "D", "peak of the velocity ahead", _SMALLEST, 0.5)),
    "v": (_M_S, Quantity("m/s", "D", "peak of the velocity to the right", _SMALLEST, 0.5)),
    "w": (_M_S, Quantity("m/s", "D", "peak of the velocity down", _SMALLEST, 0.3)),
    "r": (_DEG_S, Quantity("deg/s", "D", "peak of the yaw rate", _SMALLEST, 45.0)),
    "motor": (_V, Quantity("V", "D", "peak of the control voltage", _SMALLEST, 0.5)),
}
"""Key and range of the amplitude of each channel: the safety limit of what can be asked for."""

_DURATION = Quantity("s", "D", "duration", 1.0, 600.0)
_HOLD = Quantity("s", "D", "hold time", CONTROL_PERIOD, 60.0)
_FADE = Quantity("s", "D", "fading in, and out", 0.0, 10.0)
_FREQUENCY = Quantity("rad/s", "D", "end of the band", 0.1, 314.15)
_FEWEST_LINES = 3
_KEYS = (
    "signal",
    "channel",
    "channels",
    _DEG,
    _M_S,
    _DEG_S,
    _V,
    "band_rad_s",
    "hold",
    "duration",
    "fade",
    "seed",
)
_EXAMPLE = "{signal: prbs, channel: B_1s, amplitude_deg: 0.5, band_rad_s: [0.5, 12], duration: 60.0}"


def read_excitation(settings: object, *, file: str | None = None, key: str = "excite") -> Excitation:
    """The excitation that a mapping describes.

    Args:
        settings: as YAML gives them.
        file: they stand in, for errors.
        key: they stand under, for errors.

    Raises:
        InputError: names file, key, value and what is allowed.
    """
    if not isinstance(settings, Mapping):
        raise InputError(f"{settings!r} is no excitation", allowed=_EXAMPLE, file=file, key=key)
    return _Reader(settings, file, key).excitation()


def excitation_from_text(text: str) -> Excitation:
    """The excitation that a request describes, one mapping in YAML.

    Raises:
        InputError: names the key, the value and what is allowed.
    """
    if len(text) > LONGEST_REQUEST:
        raise InputError(f"{len(text)} characters are no excitation", allowed=_EXAMPLE, key="excite")
    return read_excitation(_yaml(text, "excite"))


def excitations_from_text(text: str) -> tuple[Excitation, ...]:
    """The excitations of a list of mappings in YAML.

    Raises:
        InputError: names the key, the value and what is allowed.
    """
    entries = _yaml(text, "excitations")
    if not isinstance(entries, list):
        raise InputError(f"{entries!r} is no list", allowed=f"[{_EXAMPLE}]", key="excitations")
    return tuple(read_excitation(entry, key=f"excitations[{i}]") for i, entry in enumerate(entries))


def excitation_mapping(excitation: Excitation) -> dict[str, object]:
    """An excitation as a plan writes it; `read_excitation` gives an equal one back."""
    one = len(excitation.channels) == 1
    key, about = _PEAKS[excitation.channels[0]]
    settings: dict[str, object] = {"signal": excitation.signal}
    settings |= {"channel": excitation.channels[0]} if one else {"channels": list(excitation.channels)}
    turns = about.unit.startswith("deg")
    settings[key] = degrees_of(excitation.amplitude) if turns else excitation.amplitude
    if excitation.band is not None:
        settings["band_rad_s"] = list(excitation.band)
    if excitation.hold is not None:
        settings["hold"] = excitation.hold
    return settings | {"duration": excitation.duration, "fade": excitation.fade, "seed": excitation.seed}


def _yaml(text: str, key: str) -> object:
    try:
        return yaml.safe_load(text)
    except yaml.YAMLError as error:
        problem = " ".join(str(error).split())[:80]
        raise InputError(f"no YAML: {problem}", allowed=_EXAMPLE, key=key) from None


class _Reader:
    """Reads one mapping; every error names its place."""

    def __init__(self, settings: Mapping[object, object], file: str | None, place: str) -> None:
        self._settings, self._file, self._place = settings, file, place

    def excitation(self) -> Excitation:
        signal, channels = self._signal(), self._channels()
        (amplitude_key,) = {_PEAKS[channel][0] for channel in channels}
        own = "band_rad_s" if signal in BANDED else "hold"
        known = ("signal", "channel", "channels", amplitude_key, own, "duration", "fade", "seed")
        for key in self._settings:
            if key not in known:
                problem = f"does not fit {signal} on {channels[0]}" if key in _KEYS else "unknown key"
                raise self._error(str(key), problem, ", ".join(known))
        if len(channels) > 1 and signal not in TOGETHER:
            problem = f"{signal} would do the same on each of them"
            raise self._error("channels", problem, f"one channel, or {', '.join(TOGETHER)}")
        abouts = [_PEAKS[channel][1] for channel in channels]
        amplitude = min(self._number(amplitude_key, about) for about in abouts)
        excitation = Excitation(
            signal=signal,
            channels=channels,
            amplitude=radians(amplitude) if abouts[0].unit.startswith("deg") else amplitude,
            duration=self._number("duration", _DURATION),
            band=self._band() if signal in BANDED else None,
            hold=self._number("hold", _HOLD) if signal in HELD else None,
            fade=self._number("fade", _FADE, Excitation.fade),
            seed=self._seed(),
        )
        self._check_length(excitation)
        return excitation

    def _signal(self) -> str:
        signal = self._settings.get("signal")
        if signal not in SIGNALS:
            raise self._error("signal", f"{signal!r} is no signal", ", ".join(SIGNALS))
        return str(signal)

    def _channels(self) -> tuple[str, ...]:
        both = "channel" in self._settings and "channels" in self._settings
        name = "channels" if "channels" in self._settings else "channel"
        given = self._settings.get(name)
        named = given if name == "channels" else [given]
        allowed = ", ".join(CHANNELS)
        if both or not isinstance(named, Sequence) or isinstance(named, str) or not named:
            raise self._error(
                name, f"{given!r} names no channels", f"channel: X or channels: [X, ...] of {allowed}"
            )
        for channel in named:
            if channel not in CHANNELS:
                raise self._error(name, f"{channel!r} is no channel", allowed)
        if len(set(named)) < len(named):
            raise self._error(name, f"{given!r} names one twice", "each channel once")
        if len({_PEAKS[channel][0] for channel in named}) > 1:
            raise self._error(name, f"{given!r} have amplitudes of different units", "channels of one unit")
        return tuple(str(channel) for channel in named)

    def _band(self) -> tuple[float, float]:
        given = self._settings.get("band_rad_s")
        if not isinstance(given, Sequence) or isinstance(given, str) or len(given) != 2:
            raise self._error("band_rad_s", f"{given!r} is no band", "[lowest, highest] in rad/s")
        key = f"{self._place}.band_rad_s"
        low, high = (check_number(value, _FREQUENCY, file=self._file, key=key) for value in given)
        if low >= high:
            raise self._error("band_rad_s", f"{given!r} is empty", "lowest below highest")
        return low, high

    def _seed(self) -> int:
        value = self._settings.get("seed", Excitation.seed)
        if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**32:
            raise self._error("seed", f"{value!r} is not allowed", f"an integer 0 .. {2**32 - 1}")
        return value

    def _check_length(self, excitation: Excitation) -> None:
        """Refuse what does not fit: fading longer than the signal, half a pattern, a band without lines."""
        if 2.0 * excitation.fade > excitation.duration:
            raise self._error("fade", f"{excitation.fade:g} is too long", "at most half of the duration")
        if excitation.hold is not None:
            levels = signals.PATTERNS.get(excitation.signal, signals.RAMPS[1:])
            shortest = len(levels) * max(CONTROL_PERIOD, excitation.hold)
            if excitation.duration < shortest - 1e-9:
                problem = f"{excitation.duration:g} is less than one pattern of {excitation.signal}"
                raise self._error("duration", problem, f"at least {shortest:g} s with this hold")
        if (
            excitation.band is not None
            and excitation.signal == "prbs"
            and not signals.prbs_bits(excitation.band)
        ):
            problem = f"{list(excitation.band)} is too narrow for a two-valued signal"
            raise self._error("band_rad_s", problem, "highest at least 3.5 times lowest")
        if excitation.band is not None and excitation.signal in ("noise", "multisine"):
            many = excitation.signal == "multisine"
            period = signals.multisine_period(excitation.count) if many else excitation.count
            least = _FEWEST_LINES * (len(excitation.channels) if many else 1)
            if signals.line_count(period, excitation.band) < least:
                seconds = period * CONTROL_PERIOD
                problem = f"{list(excitation.band)} holds too few lines of a period of {seconds:g} s"
                raise self._error(
                    "band_rad_s", problem, f"at least {least} lines: a wider band or a longer duration"
                )

    def _number(self, key: str, about: Quantity, default: float | None = None) -> float:
        value = self._settings.get(key, default)
        return check_number(value, about, file=self._file, key=f"{self._place}.{key}")

    def _error(self, key: str, problem: str, allowed: str) -> InputError:
        return InputError(problem, allowed=allowed, file=self._file, key=f"{self._place}.{key}")
