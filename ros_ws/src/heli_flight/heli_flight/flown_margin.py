"""The gain margin of a controller as it is in flight, and as the linear loop says it is (spec 3.6).

One flight in process: hover in still air, then trial after trial. In each the commands of one axis are
multiplied by a factor, the reference jumps by 3 cm, and the motion is watched; then the controller flies as
it is until all is quiet again. Below the margin the motion is the answer to the jump, much the same at every
factor; beyond it an oscillation grows until the rate limit of the servos holds it. How large it then is
depends on its frequency, 0.2 rad/s at 40 rad/s of yaw and more when slower, so it is compared with the
controller's own answer to the jump: three times that is lost. Bisection finds the factor in between,
without a look at the linear loop.

The jump is there because of dry friction: the gimbal's 0.005 N m and the arms' 0.2 N act on a motion of
0.02 rad/s as strong damping, under which a slow growth would not begin; at 0.1 rad/s they are a few percent
of the rotor's own damping. The flight is as long as it is so that slow growth is seen: 1 dB beyond
the margin of the shipped LQ controller the oscillation grows tenfold in less than 2 s.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

from heli_bench_sim import linearize
from heli_bench_sim.bench_parameters import BenchParameters
from heli_bench_sim.trim import trim
from heli_common import topics
from heli_common.errors import InputError, SafetyStop
from heli_common.timing import CONTROL_PERIOD_NS
from heli_control.attitude_control import AttitudeController
from heli_control.controller_file import AXES, ControllerAxis, ControllerFile
from heli_control.motor_control import governor_law
from heli_control.motor_controller_file import load_motor_controller
from heli_control.position_control import PositionParameters
from heli_control.position_loop import with_position_law, with_positions
from heli_control.rig_plant import MEASURED_SPEED, with_friction, with_speed_sensor
from heli_control.sampled_loop import NO_CONTROLLER, LoopTiming, SampledLoop, SampledMargins, sampled_margins
from heli_flight.components import DEFAULTS, bench_simulator, controllers, supervisor
from heli_flight.in_process import InProcessGraph
from heli_flight.parameter_file import NodeValues
from heli_flight.plan import Plan
from heli_flight.plan_phases import Home, Hover, RunUp, Step, TakeOff
from heli_navigation.navigator import NavigationParameters

HIGHEST_DB = 30.0
"""Where the search begins; beyond it the margin counts as infinite."""

RESOLUTION_DB = 0.25
WATCHED = {"horizontal": (0, 1), "vertical": (2,)}
"""Body rates whose growth is watched, of p q r."""

LOST_RATIO = 3.0
"""Largest rates, root mean square over half a second, over those of the same jump at the own gain: lost."""

NO_HOVER_RATE = 0.35
"""The same rates at which the controller, at its own gain, does not hover [rad/s]."""

_WINDOW = 50
_JUMP = 0.03
_TRIALS = 40
_SETTLE = Hover(duration=5.0)


@dataclass(frozen=True)
class Trial:
    """One factor flown.

    Attributes:
        level_db: factor on the commands of the axis [dB].
        lost: whether the motion grew to what decides.
        largest_rate: of the watched rates, root mean square over half a second [rad/s].
    """

    level_db: float
    lost: bool
    largest_rate: float


@dataclass(frozen=True)
class FlownMargin:
    """Both margins of one axis of a controller.

    Attributes:
        controller: its name. axis: `horizontal` or `vertical`.
        flown_db: between the highest factor borne and the lowest one lost [dB]; infinite if none was lost.
        linear: margins of the sampled loop with servos, pulse frames, latency, friction and position law.
        trials: in the order of flying.
    """

    controller: str
    axis: str
    flown_db: float
    linear: SampledMargins
    trials: tuple[Trial, ...]

    @property
    def difference_db(self) -> float:
        """Flown less linear [dB]."""
        return self.flown_db - self.linear.gain_up_db


def multiplied(controller: ControllerFile, axis: str, factor: float) -> ControllerFile:
    """The controller with the commands of one axis, deviations from its operating point, times a factor.

    Its states stay as they were: what it is told of limited commands is divided by the factor.

    Args:
        controller: any.
        axis: `horizontal` or `vertical`.
        factor: above 0.

    Raises:
        InputError: another axis. ValueError: a factor that is not positive.
    """
    if axis not in AXES:
        raise InputError(f"{axis!r} is no axis", allowed=", ".join(AXES), key="axis")
    if not factor > 0.0:
        raise ValueError(f"factor {factor}; allowed: above 0")
    block: ControllerAxis = getattr(controller, axis)
    system = replace(block.system, C=factor * block.system.C, D=factor * block.system.D)
    changed = ControllerAxis(system, block.anti_windup / factor)
    return replace(controller, **{axis: changed})  # type: ignore[arg-type]


def linear_loop(controller: ControllerFile, axis: str, values: NodeValues = DEFAULTS) -> SampledLoop:
    """The bench linearised at its own trim, with friction and position law, around a controller.

    The vertical one has the drive and its governor in it, within the current limit: a collective that swings
    at 50 rad/s is too fast for the governor, and the torque of the shaft turns the body.

    Args:
        controller: any; one without velocity references flies without position law.
        axis: `horizontal` or `vertical`.
        values: parameters of the nodes.

    Raises:
        InputError: another axis, or a signal that the linear bench has not.
    """
    if axis not in AXES:
        raise InputError(f"{axis!r} is no axis", allowed=", ".join(AXES), key="axis")
    bench = values.build_groups(topics.BENCH_SIM, BenchParameters)
    point, inner = trim(bench.helicopter), NO_CONTROLLER
    if axis == "horizontal":
        plant = linearize.horizontal(bench.helicopter, point)
    else:
        plant = with_speed_sensor(linearize.vertical_with_drive(bench.helicopter, point), bench.hall.lag)
        low_pass = values.build(topics.NAVIGATION, NavigationParameters).rotor_bandwidth
        inner = governor_law(load_motor_controller("motor").parameters, low_pass, MEASURED_SPEED)
    arms = {"u": bench.friction.viscous_x, "v": bench.friction.viscous_y, "w": bench.friction.viscous_z}
    viscous = {name: value for name, value in arms.items() if name in plant.states}
    plant = with_positions(with_friction(plant, viscous, bench.helicopter.mass))
    law = getattr(controller, axis).system
    if any(name.endswith("_ref") for name in law.inputs):
        law = with_position_law(law, values.build(topics.POSITION_CONTROLLER, PositionParameters))
    timing = LoopTiming()
    timing = replace(timing, latency_ns=timing.latency_ns + bench.link.dead_time_ns)
    return SampledLoop(plant, law, timing, bench.servo.bandwidth, bench.servo.damping, inner)


class MarginFlight:
    """A flight that hovers until `trial` multiplies its commands.

    Args:
        controller: any that hovers.
        axis: whose commands are multiplied.
        values: parameters of the nodes.
        seed: of every random number.
        watch: how long each trial is watched [s].

    Attributes:
        over: whether a trial ended the flight: another one is needed for the next.
    """

    def __init__(
        self,
        controller: ControllerFile,
        axis: str,
        values: NodeValues = DEFAULTS,
        seed: int = 1,
        watch: float = 8.0,
    ) -> None:
        name = "x" if axis == "horizontal" else "psi"
        steps = [Step(axis=name, amplitude=_JUMP * (-1) ** index, duration=watch) for index in range(_TRIALS)]
        trials = [phase for step in steps for phase in (step, _SETTLE)]
        phases = (Home(), RunUp(), TakeOff(speed=0.3), _SETTLE, *trials)
        plan = Plan("flown_margin", "Hover, and steps with multiplied commands.", seed, "", phases)
        self._controller, self._axis = controller, axis
        self._leader = supervisor(plan, values)
        self._bench = bench_simulator(seed, values, plan)
        parts = controllers(controller, values)
        (self._attitude,) = (part for part in parts if isinstance(part, AttitudeController))
        self._graph = InProcessGraph(self._bench, [self._leader, *parts], lambda *_: None)
        self._watch = round(watch * 1e9 / CONTROL_PERIOD_NS)
        self._next = len(phases) - len(trials)
        self.over = False

    def trial(self, level_db: float, lost_rate: float) -> Trial:
        """Settle, multiply the commands, jump, watch, and fly on as before.

        Args:
            level_db: factor on the commands [dB].
            lost_rate: of the watched rates, root mean square over half a second, that ends the trial [rad/s].

        Raises:
            SafetyStop: hover is not reached, or not kept by the controller as it is.
        """
        self._until_phase(self._next + 1)
        factor = 10.0 ** (level_db / 20.0)
        self._attitude.replace(multiplied(self._controller, self._axis, factor))
        window: deque[float] = deque(maxlen=_WINDOW)
        largest = 0.0
        for _ in range(self._watch):
            try:
                self._sample()
            except SafetyStop:
                largest, self.over = math.inf, True
            rates = self._bench.bench.rates
            window.append(sum(rates[index] ** 2 for index in WATCHED[self._axis]))
            if len(window) == _WINDOW:
                largest = max(largest, math.sqrt(sum(window) / _WINDOW))
            if largest > lost_rate:
                break
        self._attitude.replace(self._controller)
        self._next += 2
        return Trial(level_db, largest > lost_rate, largest)

    def _until_phase(self, phase: int) -> None:
        while self._leader.phase < phase:
            self._sample()

    def _sample(self) -> None:
        """Go on by one period of the controllers."""
        end = self._bench.stamp_ns + CONTROL_PERIOD_NS
        while self._bench.stamp_ns < end:
            self._graph.advance()
            if self._bench.ended_at is not None:
                raise SafetyStop(
                    f"the flight ended at {self._bench.stamp_ns * 1e-9:.2f} s: {self._leader.reason}"
                )


def flown_margin(
    controller: ControllerFile, axis: str = "horizontal", values: NodeValues = DEFAULTS, seed: int = 1
) -> FlownMargin:
    """Raise the gain of one axis by bisection until it is lost in flight; beside the linear loop's margin.

    Args:
        controller: any that hovers.
        axis: `horizontal` or `vertical`.
        values: parameters of the nodes.
        seed: of every random number.

    Raises:
        SafetyStop: it does not hover as it is. InputError: another axis.
        ValueError: the linear loop is not stable.
    """
    linear = sampled_margins(linear_loop(controller, axis, values))
    flight = MarginFlight(controller, axis, values, seed)

    trials = [flight.trial(0.0, NO_HOVER_RATE)]
    if trials[0].lost:
        raise SafetyStop(f"{controller.name} does not hover as it is: {trials[0].largest_rate:.2f} rad/s")
    lost_rate = LOST_RATIO * trials[0].largest_rate

    def flown(level_db: float) -> Trial:
        nonlocal flight
        if flight.over:
            flight = MarginFlight(controller, axis, values, seed)
        return flight.trial(level_db, lost_rate)

    trials.append(flown(HIGHEST_DB))
    if not trials[-1].lost:
        return FlownMargin(controller.name, axis, math.inf, linear, tuple(trials))
    borne, lost = 0.0, HIGHEST_DB
    while lost - borne > RESOLUTION_DB:
        trials.append(flown(0.5 * (borne + lost)))
        borne, lost = (borne, trials[-1].level_db) if trials[-1].lost else (trials[-1].level_db, lost)
    return FlownMargin(controller.name, axis, 0.5 * (borne + lost), linear, tuple(trials))
