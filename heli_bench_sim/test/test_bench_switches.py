"""Switches of the real machine in the whole helicopter: off they change nothing, on they do what they say."""

import numpy as np
import pytest
from numpy.typing import NDArray

from heli_bench_sim.h_force import HForceParameters
from heli_bench_sim.helicopter import derivative, loads
from heli_bench_sim.levers import LeverParameters
from heli_bench_sim.parameters import Constants, constants, thesis
from heli_bench_sim.states import STATE_SIZE, Input, State
from heli_bench_sim.trim import trim

Array = NDArray[np.float64]
HOVER = trim(thesis())
NONE = np.zeros(3)


def rates(c: Constants, state: Array, inputs: Array) -> Array:
    out = np.empty(STATE_SIZE)
    derivative(state, inputs, NONE, NONE, NONE, c, out)
    return out


def test_h_force_takes_torque_in_forward_flight_only() -> None:
    plain, real = constants(thesis()), constants(thesis(), h_force=HForceParameters(active=1.0))
    state, inputs = HOVER.state, HOVER.inputs
    assert (rates(real, state, inputs) == rates(plain, state, inputs)).all()
    state[State.u] = 5.0
    inputs[Input.B_1s] = -0.15  # a disc tilted into the wind pulls the helicopter through the air
    more = loads(state, inputs, NONE, real).torque - loads(state, inputs, NONE, plain).torque
    assert 0.01 < more < 0.3
    slower = rates(real, state, inputs)[State.Omega] - rates(plain, state, inputs)[State.Omega]
    assert slower == pytest.approx(-more / plain.drive_inertia, rel=1e-9)


def test_gains_follow_the_collective_and_agree_at_hover() -> None:
    plain = constants(thesis())
    real = constants(thesis(), LeverParameters(gain_slope_plate_to_blade=1.0, gain_collective=HOVER.theta_0))
    state, inputs = HOVER.state, HOVER.inputs
    assert rates(real, state, inputs) == pytest.approx(rates(plain, state, inputs), abs=1e-12)
    inputs[Input.B_1s] += 0.02
    inputs[Input.theta_0] += 0.05
    pitch = rates(real, state, inputs)[State.q] / rates(plain, state, inputs)[State.q]
    assert pitch > 1.02


def test_play_swallows_small_cyclic() -> None:
    real = constants(thesis(), LeverParameters(slack=0.02))
    state, inputs = HOVER.state, HOVER.inputs
    state[[State.a_1p, State.b_1p]] = 0.0
    still, moved = inputs.copy(), inputs.copy()
    still[[Input.B_1s, Input.A_1s]] = 0.0
    moved[[Input.B_1s, Input.A_1s]] = 0.004, 0.0
    plain = constants(thesis())

    def response(c: Constants) -> float:
        return float((rates(c, state, moved) - rates(c, state, still))[State.q])

    assert abs(response(real)) < 0.5 * abs(response(plain))
