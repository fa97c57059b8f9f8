from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from scipy.linalg import solve_discrete_lyapunov

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace
from heli_common.model_file import ModelFile
from heli_common.timing import CONTROL_PERIOD
from heli_control.controller_file import ControllerFile, load_controller
from heli_control.lq import HORIZONTAL_INPUTS, HORIZONTAL_STATES, LqWeights, design_lq
from heli_control.lq_axis import AxisDesign, controller_block, design_axis, residualised
from heli_control.lq_figures import in_printed_units
from heli_control.published_gains import LQ_GAINS
from heli_control.state_space import delayed_zero_order_hold

MODEL = ModelFile.read(Path(__file__).parent / "data" / "hover_model.yaml")
WEIGHTS = LqWeights()


def plant(states: tuple[str, ...], inputs: tuple[str, ...], a: Any, b: Any) -> StateSpace:
    n, m = len(states), len(inputs)
    return StateSpace(states, inputs, states, np.array(a), np.array(b), np.eye(n), np.zeros((n, m)))


def horizontal(delay: float = WEIGHTS.command_delay) -> AxisDesign:
    q = np.array([getattr(WEIGHTS, name) for name in HORIZONTAL_STATES])
    r = WEIGHTS.effort * np.array([1.0, WEIGHTS.rho])
    return design_axis(MODEL.horizontal, HORIZONTAL_STATES, HORIZONTAL_INPUTS, q, r, delay)


def test_gain_of_an_integrator_is_the_root_of_the_weights() -> None:
    # scaled by 0.2 m/s and 0.02 rad: gain sqrt(q / r) times 0.02 / 0.2
    integrator = plant(("w",), ("theta_0",), [[0.0]], [[-80.0]])
    design = design_axis(integrator, ("w",), ("theta_0",), np.array([4.0]), np.array([1.0]), 0.0)
    assert design.continuous[0, 0] == pytest.approx(-2.0 * 0.1)
    assert design.poles[0] == pytest.approx(-16.0)


def test_fast_state_is_replaced_by_its_rest() -> None:
    # x' = -x + y + u, y' = 2 x - 4 y + 8 u: at rest y = x/2 + 2 u, so x' = -x/2 + 3 u
    both = plant(("w", "V_i"), ("theta_0",), [[-1.0, 1.0], [2.0, -4.0]], [[1.0], [8.0]])
    a, b = residualised(both, ("w",), ("theta_0",))
    assert a.tolist() == [[-0.5]]
    assert b.tolist() == [[3.0]]


def test_main_gains_of_the_horizontal_motion_are_those_of_table_3_1() -> None:
    controller = design_lq(MODEL, WEIGHTS)
    gains = controller.provenance["horizontal"]["gains"]
    main = [("B_1s", "theta"), ("B_1s", "u"), ("B_1s", "q"), ("A_1s", "phi"), ("A_1s", "v"), ("A_1s", "p")]
    for command, state in main:
        assert gains[command][state] == pytest.approx(LQ_GAINS[command][state], rel=0.005)


def test_vertical_motion_and_yaw_cross_over_where_the_source_says() -> None:
    figures = design_lq(MODEL, WEIGHTS).provenance["vertical"]
    assert figures["crossover_rad_s"]["w"][-1] == pytest.approx(3.0, rel=0.1)
    assert figures["crossover_rad_s"]["r"][-1] == pytest.approx(12.0, rel=0.1)
    # the printed gains would cross at 3.5 and 7.8 rad/s on this plant, so they cannot be met as well
    for command, state in (("theta_0", "w"), ("theta_t", "r")):
        assert figures["gains"][command][state] == pytest.approx(LQ_GAINS[command][state], rel=0.4)


def test_continuous_gain_agrees_with_the_hamiltonian_route() -> None:
    design = horizontal()
    scale_x, scale_u = np.array([0.2, 0.2, 0.2, 0.2, 1.0, 1.0]), np.array([0.02, 0.02])
    a = design.A * scale_x[None, :] / scale_x[:, None]
    b = design.B * scale_u[None, :] / scale_x[:, None]
    q = np.diag([getattr(WEIGHTS, name) for name in HORIZONTAL_STATES])
    r = WEIGHTS.effort * np.diag([1.0, WEIGHTS.rho])
    hamiltonian = np.block([[a, -b @ np.linalg.solve(r, b.T)], [-q, -a.T]])
    values, vectors = np.linalg.eig(hamiltonian)
    stable = vectors[:, values.real < 0.0]
    cost = np.real(stable[6:] @ np.linalg.inv(stable[:6]))
    gain = np.linalg.solve(r, b.T @ cost) * scale_u[:, None] / scale_x[None, :]
    np.testing.assert_allclose(design.continuous, gain, rtol=1e-6, atol=1e-9)


def test_discrete_gain_is_a_minimum_of_the_cost() -> None:
    design = horizontal()
    a, b = delayed_zero_order_hold(design.A, design.B, CONTROL_PERIOD, WEIGHTS.command_delay)
    scale_x = np.array([0.2, 0.2, 0.2, 0.2, 1.0, 1.0])
    q = np.zeros_like(a)
    q[:6, :6] = np.diag([getattr(WEIGHTS, name) for name in HORIZONTAL_STATES] / scale_x**2)
    r = WEIGHTS.effort * np.diag([1.0, WEIGHTS.rho]) / 0.02**2

    def cost(gain: np.ndarray) -> float:
        closed = a - b @ gain
        return float(np.trace(solve_discrete_lyapunov(closed.T, q + gain.T @ r @ gain)))

    best = np.hstack((design.discrete, design.past))
    rng = np.random.default_rng(0)
    for _ in range(20):
        change = 1e-3 * np.abs(best).max() * rng.standard_normal(best.shape)
        assert cost(best + change) > cost(best)
        assert cost(best - change) > cost(best)


@pytest.mark.parametrize("delay", [0.0, 0.004, 0.01, 0.02, 0.025])
def test_controller_block_closes_the_loop_it_was_designed_for(delay: float) -> None:
    design = horizontal(delay)
    block = controller_block(design).system
    assert len(block.states) == 2 * int(np.ceil(delay / CONTROL_PERIOD - 1e-9))
    a, b = delayed_zero_order_hold(design.A, design.B, CONTROL_PERIOD, delay)
    n, k = len(a), len(block.states)
    measure = np.zeros((8, n))
    measure[:6, :6] = np.eye(6)
    closed = np.zeros((n + k, n + k))
    closed[:n, :n], closed[:n, n:] = a + b @ block.D @ measure, b @ block.C
    closed[n:, :n], closed[n:, n:] = block.B @ measure, block.A
    # the past commands are in plant and controller alike: their copies are the k extra poles
    poles = np.linalg.eigvals(closed)
    for pole in design.discrete_poles[np.abs(design.discrete_poles) > 0.05]:
        assert np.abs(poles - pole).min() < 1e-6
    assert np.abs(poles).max() < 1.0


def test_states_are_the_commands_that_were_applied() -> None:
    axis = controller_block(horizontal())  # two commands late: (newest B_1s, A_1s, older B_1s, A_1s)
    block, e = axis.system, axis.anti_windup
    state, inputs = np.array([0.01, -0.02, 0.03, -0.04]), np.linspace(0.01, 0.08, 8)
    asked = block.C @ state + block.D @ inputs
    applied = np.array([0.1, -0.2])
    after = block.A @ state + block.B @ inputs + e @ (applied - asked)
    np.testing.assert_allclose(after, [0.1, -0.2, 0.01, -0.02], atol=1e-15)
    assert controller_block(horizontal(0.0)).anti_windup.shape == (0, 2)


def test_reference_equal_to_the_velocity_asks_for_nothing() -> None:
    block = controller_block(horizontal()).system
    columns = {name: block.inputs.index(name) for name in block.inputs}
    for velocity in ("u", "v"):
        together = block.D[:, columns[velocity]] + block.D[:, columns[f"{velocity}_ref"]]
        np.testing.assert_array_equal(together, 0.0)
        together = block.B[:, columns[velocity]] + block.B[:, columns[f"{velocity}_ref"]]
        np.testing.assert_array_equal(together, 0.0)


def test_without_delay_the_controller_is_a_gain_and_nearly_the_continuous_one_at_100_kilohertz() -> None:
    static = design_lq(MODEL, replace(WEIGHTS, command_delay=0.0))
    assert static.horizontal.system.states == ()
    slow = plant(("w",), ("theta_0",), [[-0.01]], [[-0.5]])
    design = design_axis(slow, ("w",), ("theta_0",), np.array([1.0]), np.array([1.0]), 0.0)
    assert design.discrete[0, 0] == pytest.approx(design.continuous[0, 0], rel=1e-3)


def test_six_state_model_gives_the_same_controller() -> None:
    a, b = residualised(MODEL.horizontal, HORIZONTAL_STATES, HORIZONTAL_INPUTS)
    six = plant(HORIZONTAL_STATES, HORIZONTAL_INPUTS, a, b)
    first, second = design_lq(MODEL, WEIGHTS), design_lq(replace(MODEL, horizontal=six), WEIGHTS)
    np.testing.assert_allclose(second.horizontal.system.D, first.horizontal.system.D, rtol=1e-9)
    assert second.plant_hash != first.plant_hash


def test_signs_bring_the_helicopter_back() -> None:
    direct = design_lq(MODEL, WEIGHTS)
    h, v = direct.horizontal.system, direct.vertical.system

    def answer(block: StateSpace, output: str, signal: str) -> float:
        return float(block.D[block.outputs.index(output), block.inputs.index(signal)])

    assert answer(h, "B_1s", "theta") < 0.0  # nose up: disc forward
    assert answer(h, "B_1s", "u") > 0.0  # too fast forward: disc back
    assert answer(h, "A_1s", "phi") < 0.0  # right side down: disc left
    assert answer(h, "A_1s", "v") < 0.0  # drifting right: disc left
    assert answer(v, "theta_0", "w") > 0.0  # sinking: more collective
    assert answer(v, "theta_t", "r") > 0.0  # nose turning right: tail thrust turns it left


def test_provenance_says_all_and_the_file_comes_back(tmp_path: Path) -> None:
    controller = design_lq(MODEL, WEIGHTS)
    assert controller.plant_hash == MODEL.plant_hash
    assert controller.provenance["weights"] == asdict(WEIGHTS)
    assert set(controller.provenance["software"]) == {"python", "heli_control", "numpy", "scipy"}
    for axis in ("horizontal", "vertical"):
        figures = controller.provenance[axis]
        assert max(pole[0] for pole in figures["poles"]) < 0.0
        assert max(np.hypot(*pole) for pole in figures["poles_discrete_z"]) < 1.0
        assert figures["peaks_discrete_db"]["S_u"] < 6.0
        assert figures["peaks_discrete_db"]["T_u"] < 6.0
    controller.write(tmp_path / "lq.yaml")
    assert ControllerFile.read(tmp_path / "lq.yaml").to_yaml() == controller.to_yaml()
    assert yaml.safe_load(controller.to_yaml())["provenance"] == controller.provenance


def test_shipped_controller_is_the_default_design() -> None:
    shipped, designed = load_controller("lq"), design_lq(MODEL, WEIGHTS)
    assert shipped.plant_hash == designed.plant_hash
    assert shipped.provenance["weights"] == asdict(WEIGHTS)
    for axis in ("horizontal", "vertical"):
        ours, theirs = getattr(designed, axis), getattr(shipped, axis)
        for matrix in "ABCD":
            close = {"rtol": 1e-6, "atol": 1e-12}
            np.testing.assert_allclose(getattr(theirs.system, matrix), getattr(ours.system, matrix), **close)
        np.testing.assert_array_equal(theirs.anti_windup, ours.anti_windup)


def test_printed_units() -> None:
    printed = in_printed_units(np.array([[0.5, np.pi / 180.0]]), ("theta", "u"), ("B_1s",))
    assert printed == {"B_1s": {"theta": 0.5, "u": pytest.approx(1.0)}}


def test_model_that_lacks_a_state_or_cannot_be_stabilised_is_refused() -> None:
    with pytest.raises(InputError, match="w, r lacks 'theta'"):
        design_lq(
            replace(MODEL, horizontal=plant(("w", "r"), ("B_1s",), np.eye(2), np.ones((2, 1)))), WEIGHTS
        )
    growing = plant(("w", "V_i"), ("theta_0",), [[-1.0, 1.0], [2.0, 4.0]], [[1.0], [8.0]])
    with pytest.raises(InputError, match="V_i do not come to rest"):
        residualised(growing, ("w",), ("theta_0",))
    deaf = plant(("w", "r"), ("theta_0", "theta_t"), [[1.0, 0.0], [0.0, -1.0]], [[0.0, 0.0], [0.0, 1.0]])
    with pytest.raises(InputError, match="no stabilising solution"):
        design_lq(replace(MODEL, vertical=deaf), WEIGHTS)
