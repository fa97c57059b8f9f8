"""The loop as it flies: continuous plant and servos, pulse frames, latency, a sampled controller; exactly.

A command computed from the sample t_k can be taken at t_k + latency. Pulse frames latch the newest such
command every 20 ms (spec 6.4); a frame may reach the servos late by a dead time. With two controller samples
per frame the loop is linear and periodic: seen once per frame it is an ordinary difference equation

    z+ = A z + B p,    c = C z        z plant, servos, controller, commands and frames under way

from the frame latched to the command that the next latch finds. Closed, with the commands times k, it has the
matrix A + k B C. A frequency response of this loop exists on the grid of the frames; at 100 Hz there is none,
because every other command is never latched.

A second controller of the same rate may act without frames, each command as soon as it is there: the motor's.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import expm

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace
from heli_common.timing import COMMAND_LATENCY_NS, CONTROL_PERIOD_NS, PWM_PERIOD_NS
from heli_control.discretisation import SERVO_BANDWIDTH, SERVO_DAMPING, sampled_response
from heli_control.realisation import Array, Complex, Realisation

_GAIN_STEP_DB, _GAIN_RANGE_DB = 0.25, 60.0
_DELAY_STEP, _DELAY_RANGE = 0.001, 0.5
_HALVINGS = 20

NO_CONTROLLER = StateSpace((), (), (), *(np.zeros((0, 0)) for _ in "ABCD"))


@dataclass(frozen=True)
class LoopTiming:
    """When things happen, in ns (spec 6.4).

    Attributes:
        control_ns: period of the controller.
        pulse_ns: period of the pulse frames, a multiple of the controller's.
        latch_ns: of a frame after the sample it begins with, below `pulse_ns`.
        latency_ns: from a sample to its command being there; a wireless link adds its dead time.
        dead_ns: from a latch to the servos.
        inner_latency_ns: from a sample to the command of the inner controller acting.
    """

    control_ns: int = CONTROL_PERIOD_NS
    pulse_ns: int = PWM_PERIOD_NS
    latch_ns: int = COMMAND_LATENCY_NS
    latency_ns: int = COMMAND_LATENCY_NS
    dead_ns: int = 0
    inner_latency_ns: int = COMMAND_LATENCY_NS

    def __post_init__(self) -> None:
        if self.control_ns <= 0 or self.pulse_ns % self.control_ns:
            raise ValueError(f"pulse_ns {self.pulse_ns}; allowed: a multiple of {self.control_ns}")
        if not 0 <= self.latch_ns < self.pulse_ns:
            raise ValueError(f"latch_ns {self.latch_ns}; allowed: 0 .. {self.pulse_ns - 1}")
        for name in ("latency_ns", "dead_ns", "inner_latency_ns"):
            if getattr(self, name) < 0:
                raise ValueError(f"{name} {getattr(self, name)}; allowed: not negative")

    @property
    def age(self) -> int:
        """How many samples before the newest one the latched command was computed."""
        newest = self.latch_ns // self.control_ns
        return max(0, newest - (self.latch_ns - self.latency_ns) // self.control_ns)


@dataclass(frozen=True, eq=False)
class SampledLoop:
    """A plant and the controller that flies it.

    Attributes:
        plant: continuous; its inputs are commands or more, its outputs what the controller measures.
        controller: command = C x + D measured, at the rate of `timing`; inputs that end in `_ref` are zero.
        timing: see there.
        servo_bandwidth: natural frequency [rad/s].
        servo_damping: damping ratio.
        inner: command = C x + D measured at the same rate, without servos and pulse frames.

    Raises:
        InputError: a signal that the plant has not.
    """

    plant: StateSpace
    controller: StateSpace
    timing: LoopTiming = LoopTiming()
    servo_bandwidth: float = SERVO_BANDWIDTH
    servo_damping: float = SERVO_DAMPING
    inner: StateSpace = NO_CONTROLLER

    def __post_init__(self) -> None:
        for name in self.measured + self.inner.inputs:
            if name not in self.plant.outputs:
                raise InputError(f"{name!r} is no output of the plant", allowed=", ".join(self.plant.outputs))
        for name in self.controller.outputs + self.inner.outputs:
            if name not in self.plant.inputs:
                raise InputError(f"{name!r} is no input of the plant", allowed=", ".join(self.plant.inputs))

    @property
    def measured(self) -> tuple[str, ...]:
        """Inputs of the controller that are no references."""
        return tuple(name for name in self.controller.inputs if not name.endswith("_ref"))


@dataclass(frozen=True)
class SampledMargins:
    """How far a stable sampled loop is from instability; infinite beyond 60 dB and 500 ms.

    Attributes:
        spectral_radius: per frame, below 1.
        gain_up_db: factor on all commands [dB]. gain_down_db: the same downwards, positive.
        delay_ms: dead time between frames and servos [ms].
    """

    spectral_radius: float
    gain_up_db: float
    gain_down_db: float
    delay_ms: float


def opened(loop: SampledLoop) -> Realisation:
    """The difference equation of one frame, from the frame latched to the next command; feedback positive.

    States: plant, servos (angles, then rates), controller, commands newest first, frames newest first, inner
    controller, its commands newest first, the frame and the inner command that act now. The period begins
    with a sample.
    """
    t, inner = loop.timing, loop.inner
    n, m, k, m_i = (
        len(loop.plant.states),
        len(loop.controller.outputs),
        len(loop.controller.states),
        len(inner.outputs),
    )
    late = t.dead_ns // t.pulse_ns
    inner_late, inner_instant = divmod(t.inner_latency_ns, t.control_ns)
    sizes = (
        *(n + 2 * m, k, (t.age + 1) * m, (late + 1) * m),
        *(len(inner.states), (inner_late + 1) * m_i, m, m_i),
    )
    ends = np.cumsum(sizes)
    moving, control, commands, frames, inner_control, inner_commands, now, inner_now = (
        slice(int(end - size), int(end)) for end, size in zip(ends, sizes, strict=True)
    )
    size = int(ends[-1])
    held = slice(now.start, size)
    matrix: Array = np.eye(size)
    entered: Array = np.zeros((size, m))
    seen: Array = np.zeros((m, size))
    a, b, c = _plant_with_servos(loop)
    seen_outer, seen_inner = c[: len(loop.measured)], c[len(loop.measured) :]
    outer = loop.controller.part(loop.controller.states, loop.measured, loop.controller.outputs)
    sampled: Array = np.eye(size)
    _step(sampled, outer, seen_outer, moving, control, commands)
    _step(sampled, inner, seen_inner, moving, inner_control, inner_commands)
    latched: Array = np.eye(size)
    reached: Array = np.eye(size)
    _shift(latched, frames, m)
    entry = np.zeros((size, m))
    entry[frames.start : frames.start + m] = np.eye(m)
    reached[now] = 0.0
    reached[now, frames.stop - m : frames.stop] = np.eye(m)
    acting: Array = np.eye(size)
    acting[inner_now] = 0.0
    acting[inner_now, inner_commands.stop - m_i : inner_commands.stop] = np.eye(m_i)
    samples = range(0, t.pulse_ns, t.control_ns)
    events = [(instant, 0) for instant in samples] + [(instant + inner_instant, 3) for instant in samples]
    events += [(t.latch_ns, 1), ((t.latch_ns + t.dead_ns) % t.pulse_ns, 2)]
    clock = 0
    for instant, kind in [*sorted(events), (t.pulse_ns, -1)]:
        if instant > clock:
            flow = np.eye(size)
            flow[moving, moving], flow[moving, held] = _held(a, b, (instant - clock) * 1e-9)
            matrix, entered, clock = flow @ matrix, flow @ entered, instant
        if kind == 0:
            matrix, entered = sampled @ matrix, sampled @ entered
        elif kind == 1:
            seen = matrix[commands.stop - m : commands.stop].copy()
            matrix, entered = latched @ matrix, latched @ entered + entry
        elif kind == 2:
            matrix, entered = reached @ matrix, reached @ entered
        elif kind == 3:
            matrix, entered = acting @ matrix, acting @ entered
    return Realisation(matrix, entered, seen, np.zeros((m, m)))


def closed_matrix(frame: Realisation, factor: float | Array = 1.0) -> Array:
    """Matrix of the closed loop per frame, with the commands times a factor, or one per command."""
    return np.asarray(frame.A + (frame.B * factor) @ frame.C, dtype=np.float64)


def spectral_radius(frame: Realisation, factor: float | Array = 1.0) -> float:
    """Largest absolute eigenvalue of the closed loop per frame; stable below 1."""
    return float(np.abs(np.linalg.eigvals(closed_matrix(frame, factor))).max())


def loop_response(loop: SampledLoop, omega: Array) -> Complex:
    """L at the frames, for negative feedback, shape (k, m, m); omega up to pi / 20 ms.

    It has everything in it that delays the loop, and goes into `margins.loop_margins` as it is.
    """
    return -sampled_response(opened(loop), omega, loop.timing.pulse_ns * 1e-9)


def sampled_margins(loop: SampledLoop) -> SampledMargins:
    """Gain and delay margins by the eigenvalues of the closed loop themselves.

    Raises:
        ValueError: the loop is not stable as it is.
    """
    frame = opened(loop)
    radius = spectral_radius(frame)
    if not radius < 1.0:
        raise ValueError(f"the sampled loop is not stable: spectral radius {radius:.6g}; allowed: below 1")

    def by_gain(sign: float) -> Callable[[float], bool]:
        return lambda level: spectral_radius(frame, 10.0 ** (sign * level / 20.0)) < 1.0

    def by_delay(delay: float) -> bool:
        dead = loop.timing.dead_ns + round(delay * 1e9)
        return spectral_radius(opened(replace(loop, timing=replace(loop.timing, dead_ns=dead)))) < 1.0

    return SampledMargins(
        radius,
        _limit(by_gain(1.0), _GAIN_STEP_DB, _GAIN_RANGE_DB),
        _limit(by_gain(-1.0), _GAIN_STEP_DB, _GAIN_RANGE_DB),
        1e3 * _limit(by_delay, _DELAY_STEP, _DELAY_RANGE),
    )


def _plant_with_servos(loop: SampledLoop) -> tuple[Array, Array, Array]:
    """x' = a x + b (frame, inner command) for the states of plant, servo angles and servo rates.

    What both controllers measure, c x, has nothing at once of inner commands.
    """
    plant, m = loop.plant, len(loop.controller.outputs)
    n = len(plant.states)
    columns = [plant.inputs.index(name) for name in loop.controller.outputs]
    direct = [plant.inputs.index(name) for name in loop.inner.outputs]
    rows = [plant.outputs.index(name) for name in loop.measured + loop.inner.inputs]
    square = loop.servo_bandwidth**2
    angles, rates = slice(n, n + m), slice(n + m, n + 2 * m)
    a, b = np.zeros((n + 2 * m, n + 2 * m)), np.zeros((n + 2 * m, m + len(direct)))
    c = np.zeros((len(rows), n + 2 * m))
    a[:n, :n], a[:n, angles] = plant.A, plant.B[:, columns]
    a[angles, rates] = np.eye(m)
    a[rates, angles], a[rates, rates] = (
        -square * np.eye(m),
        -2.0 * loop.servo_damping * loop.servo_bandwidth * np.eye(m),
    )
    b[rates, :m], b[:n, m:] = square * np.eye(m), plant.B[:, direct]
    c[:, :n], c[:, angles] = plant.C[rows], plant.D[np.ix_(rows, columns)]
    return a, b, c


def _held(a: Array, b: Array, duration: float) -> tuple[Array, Array]:
    n, m = b.shape
    together = np.zeros((n + m, n + m))
    together[:n, :n], together[:n, n:] = a, b
    exponential = np.asarray(expm(together * duration), dtype=np.float64)
    return exponential[:n, :n], exponential[:n, n:]


def _step(
    event: Array, law: StateSpace, measured: Array, moving: slice, states: slice, commands: slice
) -> None:
    """Make the event a sample of a controller: its states go on, its command joins the line."""
    m = len(law.outputs)
    event[states] = 0.0
    event[states, states], event[states, moving] = law.A, law.B @ measured
    _shift(event, commands, m)
    first = slice(commands.start, commands.start + m)
    event[first, states], event[first, moving] = law.C, law.D @ measured


def _shift(event: Array, line: slice, m: int) -> None:
    """Make the event move a line of m-vectors on by one; the newest becomes zero."""
    event[line] = 0.0
    event[line.start + m : line.stop, line.start : line.stop - m] = np.eye(line.stop - line.start - m)


def _limit(stable: Callable[[float], bool], step: float, reach: float) -> float:
    """The first level at which it is not stable, to step / 2^20; infinite beyond `reach`."""
    for count in range(1, math.ceil(reach / step) + 1):
        if not stable(count * step):
            low, high = (count - 1) * step, count * step
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if stable(middle) else (low, middle)
            return 0.5 * (low + high)
    return math.inf
