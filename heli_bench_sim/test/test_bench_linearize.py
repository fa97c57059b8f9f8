"""Linear models against the source's Tables 2.5 and 2.6 as rebuilt in spec 1.5, and against other means."""

import dataclasses
import math

import numpy as np
import pytest

from heli_bench_sim.linearize import (
    HORIZONTAL_INPUTS,
    HORIZONTAL_OUTPUTS,
    HORIZONTAL_STATES,
    angular_derivatives,
    horizontal,
    jacobian,
    linearize,
    speed_derivatives,
    vertical,
    vertical_with_drive,
)
from heli_bench_sim.parameters import HelicopterParameters, constants, physical_tail, thesis
from heli_bench_sim.states import INPUT_NAMES, MEASURED_NAMES, STATE_NAMES
from heli_bench_sim.trim import Trim, trim

SETS = {"thesis": thesis(), "physical_tail": physical_tail()}
TRIMS = {name: trim(parameters) for name, parameters in SETS.items()}
FULL = {name: linearize(parameters, TRIMS[name]) for name, parameters in SETS.items()}


def test_jacobian_of_a_known_function() -> None:
    point = np.array([0.3, -2.0])
    found = jacobian(lambda x: np.array([x[0] ** 3 * x[1], math.sin(x[1])]), point)
    exact = [[3 * 0.09 * -2.0, 0.027], [0.0, math.cos(-2.0)]]
    assert found == pytest.approx(np.array(exact), rel=1e-10, abs=1e-12)


def test_layout() -> None:
    model = FULL["thesis"]
    assert (model.states, model.inputs, model.outputs) == (STATE_NAMES, INPUT_NAMES, MEASURED_NAMES)
    assert model.A.shape == (18, 18)
    assert model.B.shape == (18, 5)
    assert model.C.shape == (13, 18)
    assert not model.D.any()
    part = horizontal(SETS["thesis"], TRIMS["thesis"])
    assert (part.states, part.inputs, part.outputs) == (
        HORIZONTAL_STATES,
        HORIZONTAL_INPUTS,
        HORIZONTAL_OUTPUTS,
    )
    assert np.eye(8)[:6] == pytest.approx(part.C)
    with pytest.raises(ValueError, match="'omega' is none of"):
        model.part(["omega"], [], [])


@pytest.mark.parametrize("name", SETS)
def test_fast_horizontal_poles(name: str) -> None:
    poles = horizontal(SETS[name], TRIMS[name]).poles
    assert poles[0] == pytest.approx(-23.08 + 21.77j, rel=5e-4)
    assert poles[2] == pytest.approx(-12.43 + 16.02j, rel=5e-4)
    assert poles[1::2] == pytest.approx(poles[::2].conj())


@pytest.mark.parametrize(
    ("name", "pairs"),
    [
        ("thesis", (0.024 + 0.448j, -0.031 + 0.446j)),
        ("physical_tail", (0.011 + 0.461j, -0.086 + 0.435j)),
    ],
)
def test_slow_horizontal_poles(name: str, pairs: tuple[complex, complex]) -> None:
    slow = horizontal(SETS[name], TRIMS[name]).poles[4:]
    for pair in pairs:
        assert np.abs(slow - pair).min() < 1e-3


@pytest.mark.parametrize("name", SETS)
def test_drive_whose_torque_holds_the_rotor_speed_is_the_ideal_governor(name: str) -> None:
    """With M_A such that Omega' = 0 the model with drive is that of the held rotor speed."""
    full, held = vertical_with_drive(SETS[name], TRIMS[name]), vertical(SETS[name], TRIMS[name])
    omega, torque = full.states.index("Omega"), full.states.index("M_A")
    share = full.A[:4, torque] / full.A[omega, torque]
    np.testing.assert_allclose(full.A[:4, :4] - np.outer(share, full.A[omega, :4]), held.A, atol=1e-6)
    np.testing.assert_allclose(full.B[:4, :2] - np.outer(share, full.B[omega, :2]), held.B, atol=1e-6)
    assert full.states[:4] == held.states
    assert full.outputs == ("w", "r", "Omega")


def test_vertical_poles() -> None:
    assert vertical(SETS["thesis"], TRIMS["thesis"]).poles == pytest.approx(
        np.array([-22.45, -10.13, -0.852, -0.689]), rel=1e-3
    )
    assert vertical(SETS["physical_tail"], TRIMS["physical_tail"]).poles.real == pytest.approx(
        np.array([-21.73, -10.13, -0.852, -0.689]), rel=1e-3
    )


REBUILT = {
    "M_q": -13.81,
    "L_p": -34.69,
    "M_a": 242.35,
    "M_b": 64.31,
    "L_a": -161.61,
    "L_b": 608.98,
    "M_1": 2.654,
    "M_2": 0.704,
    "L_1": -1.770,
    "L_2": 6.668,
}
SOURCE = {
    "M_q": -13.81,
    "L_p": -34.702,
    "M_a": 242.54,
    "M_b": 64.313,
    "L_a": -161.52,
    "L_b": 609.11,
    "M_1": 2.65,
    "M_2": 0.7046,
    "L_1": -1.7697,
    "L_2": 6.673,
}


@pytest.mark.parametrize("name", SETS)
def test_angular_derivatives(name: str) -> None:
    found = dataclasses.asdict(angular_derivatives(FULL[name]))
    assert found == pytest.approx(REBUILT, rel=5e-4)
    assert found == pytest.approx(SOURCE, rel=1.7e-3)


def test_speed_derivatives() -> None:
    found = dataclasses.asdict(speed_derivatives(FULL["thesis"]))
    rebuilt = {"M_u": 0.717, "M_v": -0.190, "L_u": -0.478, "L_v": -1.802, "X_u": -0.0148, "Y_v": -0.0148}
    assert found == pytest.approx(rebuilt, abs=6e-4)
    assert speed_derivatives(FULL["physical_tail"]).Y_v == pytest.approx(-0.149, abs=6e-4)


@pytest.mark.parametrize("name", SETS)
def test_another_step_gives_the_same_model(name: str) -> None:
    for step in (3e-4, 3e-5):
        other = linearize(SETS[name], TRIMS[name], step=step)
        assert pytest.approx(FULL[name].A, rel=1e-7, abs=2e-6) == other.A
        assert pytest.approx(FULL[name].B, rel=1e-7, abs=1e-7) == other.B


def by_hand(h: HelicopterParameters, point: Trim) -> dict[str, float]:
    """The angular derivatives on paper: disc tilt times (hub stiffness + thrust times mast height)."""
    blade = h.air_density * h.chord * h.lift_slope
    lock = h.lock_factor * blade * (h.radius**4 - h.cutout**4) / h.blade_inertia
    centre = 0.5 * (h.radius + h.cutout)
    xi = math.atan(h.hinge_offset * h.blade_mass * centre / h.blade_inertia / (lock / 8.0))
    thrust = point.V_i * 2.0 * h.air_density * math.pi * h.radius**2
    thrust *= math.sqrt(h.mass * h.gravity / (2.0 * h.air_density * math.pi * h.radius**2))
    back = point.a_1p * h.bar_to_blade + h.plate_to_blade * point.B_1s
    right = point.b_1p * h.bar_to_blade + h.plate_to_blade * point.A_1s
    a_1 = math.cos(xi) * (math.cos(xi) * back + math.sin(xi) * right)
    b_1 = math.cos(xi) * (math.cos(xi) * right - math.sin(xi) * back)
    stiffness = h.blade_mass * centre * h.hinge_offset * h.rotor_speed**2
    pitch_a = stiffness - h.hub_z * thrust * math.cos(a_1) - h.hub_x * thrust * math.sin(a_1) * math.cos(b_1)
    pitch_b = -h.hub_x * thrust * math.cos(a_1) * math.sin(b_1)
    roll_b = stiffness - h.hub_z * thrust * math.cos(b_1)
    tau, per = 16.0 / (lock * h.rotor_speed), 1.0 / h.rotor_speed
    direct, cross = math.cos(xi) ** 2, math.cos(xi) * math.sin(xi)

    def pitching(tilt_back: float, tilt_right: float) -> float:
        moved_a, moved_b = direct * tilt_back + cross * tilt_right, direct * tilt_right - cross * tilt_back
        return (pitch_a * moved_a + pitch_b * moved_b) / h.inertia_yy

    def rolling(tilt_back: float, tilt_right: float) -> float:
        return roll_b * (direct * tilt_right - cross * tilt_back) / h.inertia_xx

    degree = math.radians(1.0)
    return {
        "M_q": pitching(-tau, -per),
        "L_p": rolling(per, -tau),
        "M_a": pitching(h.bar_to_blade, 0.0),
        "M_b": pitching(0.0, h.bar_to_blade),
        "L_a": rolling(h.bar_to_blade, 0.0),
        "L_b": rolling(0.0, h.bar_to_blade),
        "M_1": pitching(h.plate_to_blade, 0.0) * degree,
        "M_2": pitching(0.0, h.plate_to_blade) * degree,
        "L_1": rolling(h.plate_to_blade, 0.0) * degree,
        "L_2": rolling(0.0, h.plate_to_blade) * degree,
    }


@pytest.mark.parametrize("name", SETS)
def test_angular_derivatives_by_hand(name: str) -> None:
    found = dataclasses.asdict(angular_derivatives(FULL[name]))
    assert found == pytest.approx(by_hand(SETS[name], TRIMS[name]), rel=1e-8)


def test_kinematics_and_gravity_by_hand() -> None:
    model, point = FULL["thesis"], TRIMS["thesis"]

    def entry(state: str, cause: str) -> float:
        return float(model.A[model.states.index(state), model.states.index(cause)])

    assert entry("x", "u") == pytest.approx(math.cos(point.theta), rel=1e-9)
    assert entry("u", "theta") == pytest.approx(-9.81 * math.cos(point.theta), rel=1e-8)
    assert entry("v", "phi") == pytest.approx(9.81 * math.cos(point.theta) * math.cos(point.phi), rel=1e-8)
    assert entry("M_A", "M_A") == pytest.approx(-1.0 / 0.0134, rel=1e-9)
    assert entry("M_A", "Omega") == pytest.approx(-(0.0150**2) * 8.0 / 0.0467 / 0.0134, rel=1e-7)
    assert entry("V_i", "V_i") < -1.0 / 0.15
    assert model.A[:, :4] == pytest.approx(np.vstack([model.A[:3, :4], np.zeros((15, 4))]), abs=1e-9)


def test_held_rotor_speed_is_the_limit_of_a_heavy_shaft() -> None:
    """Twin of the ideal governor: an armature so heavy that Omega cannot change."""
    heavy = dataclasses.replace(SETS["thesis"], motor_inertia=1.0)
    heavy_model = linearize(heavy, trim(heavy))
    held = linearize(SETS["thesis"], TRIMS["thesis"], rotor_speed_held=True)
    rows = [STATE_NAMES.index(name) for name in ("w", "r", "V_i", "V_t")]
    assert heavy_model.A[np.ix_(rows, rows)] == pytest.approx(held.A[np.ix_(rows, rows)], rel=2e-2, abs=2e-3)
    omega = STATE_NAMES.index("Omega")
    assert held.A[omega] == pytest.approx(np.zeros(18), abs=1e-9)


def test_drag_does_not_change_the_linear_model() -> None:
    slick = dataclasses.replace(SETS["thesis"], drag_area=0.0)
    assert constants(slick).drag_area == 0.0
    model = linearize(slick, trim(slick))
    assert pytest.approx(FULL["thesis"].A, rel=1e-7, abs=2e-6) == model.A
