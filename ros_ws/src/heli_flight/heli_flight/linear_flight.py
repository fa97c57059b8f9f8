"""The steps of F1 and F7 on the linear plant: the same controller, pulse frames and latency, no sensors.

Plant, friction of the arms, servos and positions are linear and advance exactly; the controller file's
horizontal law and the position law act as they do in flight. Everything counts from the operating point.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, expm

from heli_bench_sim import linearize
from heli_bench_sim.bench_parameters import BenchParameters
from heli_bench_sim.trim import trim
from heli_common import topics
from heli_common.linear_model import StateSpace
from heli_common.rotations import Euler
from heli_common.timing import COMMAND_LATENCY_NS, CONTROL_PERIOD, CONTROL_PERIOD_NS, PWM_PERIOD_NS
from heli_common.vehicle_state import VehicleState
from heli_control.controller_file import ControllerFile
from heli_control.position_control import PositionLaw, PositionParameters
from heli_control.position_loop import with_positions
from heli_control.rig_plant import with_friction
from heli_flight.components import DEFAULTS
from heli_flight.parameter_file import NodeValues

Array = NDArray[np.float64]

SIGNALS = ("x", "y", "theta", "phi", "u", "v")
"""What is returned of each sample."""


@dataclass(frozen=True, eq=False)
class LinearFlight:
    """A flight of the linear plant at 100 Hz, n samples, deviations from the operating point.

    Attributes:
        time: [s], shape (n,).
        motion: x, y [m], theta, phi [rad], u, v [m/s], shape (n, 6).
        command: B_1s, A_1s [rad], shape (n, 2).
    """

    time: Array
    motion: Array
    command: Array

    def column(self, name: str) -> Array:
        """One of SIGNALS over time, shape (n,)."""
        return np.asarray(self.motion[:, SIGNALS.index(name)], dtype=np.float64)


def horizontal_rig(values: NodeValues = DEFAULTS) -> tuple[StateSpace, float, float]:
    """The linear plant with friction and positions; bandwidth [rad/s] and damping of the servos."""
    bench = values.build_groups(topics.BENCH_SIM, BenchParameters)
    plant = linearize.horizontal(bench.helicopter, trim(bench.helicopter))
    arms = {"u": bench.friction.viscous_x, "v": bench.friction.viscous_y}
    plant = with_positions(with_friction(plant, arms, bench.helicopter.mass))
    return plant, bench.servo.bandwidth, bench.servo.damping


def fly_linear(
    controller: ControllerFile, reference: Array, feed_forward: Array, values: NodeValues = DEFAULTS
) -> LinearFlight:
    """Fly references from rest at the origin.

    Args:
        controller: whose horizontal law flies.
        reference: x, y at every control tick [m], shape (n, 2).
        feed_forward: added to the velocity reference ahead and to the right [m/s], shape (n, 2).
        values: parameters of the nodes.

    Raises:
        ValueError: shapes that do not fit.
    """
    count = len(reference)
    if reference.shape != (count, 2) or feed_forward.shape != (count, 2):
        raise ValueError(f"shapes {reference.shape} and {feed_forward.shape}; allowed: (n, 2) both")
    plant, bandwidth, damping = horizontal_rig(values)
    early, late = COMMAND_LATENCY_NS * 1e-9, (CONTROL_PERIOD_NS - COMMAND_LATENCY_NS) * 1e-9
    flows = {duration: _flow(plant, bandwidth, damping, duration) for duration in (early, late)}
    law = controller.horizontal.system
    memory: Array = np.zeros(len(law.states))
    rig: Array = np.zeros(len(plant.states) + 4)
    latched: Array = np.zeros(2)
    asked: Array = np.zeros(2)
    places = [plant.states.index(name) for name in SIGNALS]
    rates = [plant.states.index(name) for name in ("q", "p")]
    outer = PositionLaw(values.build(topics.POSITION_CONTROLLER, PositionParameters))
    motion, command = np.empty((count, len(SIGNALS))), np.empty((count, 2))
    frame = PWM_PERIOD_NS // CONTROL_PERIOD_NS
    for tick in range(count):
        x, y, theta, phi, u, v = rig[places].tolist()
        q, p = rig[rates].tolist()
        state = VehicleState((x, y, 0.0), Euler(0.0, theta, phi), (u, v, 0.0), (p, q, 0.0), True)
        north, east = reference[tick].tolist()
        ahead, right = feed_forward[tick].tolist()
        u_ref, v_ref, _, _ = outer.step(state, (north, east, 0.0), 0.0, (ahead, right, 0.0, 0.0))
        known = {"theta": theta, "phi": phi, "u": u, "v": v, "q": q, "p": p, "u_ref": u_ref, "v_ref": v_ref}
        seen = np.array([known[name] for name in law.inputs])
        outputs = law.C @ memory + law.D @ seen
        memory = law.A @ memory + law.B @ seen
        asked = np.array([outputs[law.outputs.index(name)] for name in ("B_1s", "A_1s")])
        motion[tick], command[tick] = rig[places], asked
        for duration, latches in ((early, False), (late, tick % frame == 0)):
            if latches:
                latched = asked
            moved, driven = flows[duration]
            rig = moved @ rig + driven @ latched
    time: Array = np.arange(count, dtype=np.float64) * CONTROL_PERIOD
    return LinearFlight(time, motion, command)


def _flow(plant: StateSpace, bandwidth: float, damping: float, duration: float) -> tuple[Array, Array]:
    """How plant and servos move under held commands: x+ = first x + second command."""
    servo = np.array([[0.0, 1.0], [-(bandwidth**2), -2.0 * damping * bandwidth]])
    n = len(plant.states)
    columns = [plant.inputs.index(name) for name in ("B_1s", "A_1s")]
    a = block_diag(plant.A, servo, servo)
    a[:n, n], a[:n, n + 2] = plant.B[:, columns].T
    b = np.zeros((n + 4, 2))
    b[n + 1, 0] = b[n + 3, 1] = bandwidth**2
    whole = np.zeros((n + 6, n + 6))
    whole[: n + 4, : n + 4], whole[: n + 4, n + 4 :] = a, b
    flown = expm(whole * duration)
    return flown[: n + 4, : n + 4], flown[: n + 4, n + 4 :]
