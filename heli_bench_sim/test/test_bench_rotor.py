"""Main rotor, tail rotor, flapping, servo rotor: a case by hand, then the numerical twin of each formula."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from heli_bench_sim import flapping, rotor, servo_rotor, tail_rotor
from heli_bench_sim.parameters import HelicopterParameters, constants, physical_tail, thesis
from heli_bench_sim.standstill import reciprocal_speed

P = thesis()
C = constants(P)
OMEGA = P.rotor_speed


def test_thrust_by_hand() -> None:
    """theta_0 = 0.1 rad, no flow: eta rho c a theta_0 Omega^2 (R^3 - r_0^3) / 3."""
    expected = 0.4899 * 1.2056 * 0.062 * 5.0 * 0.1 * 163.363**2 * (0.725**3 - 0.12**3) / 3.0
    assert expected == pytest.approx(61.8, abs=0.1)
    assert rotor.thrust(0.1, OMEGA, 0.0, 0.0, 0.0, 0.0, C) == pytest.approx(expected, rel=1e-14)


@settings(deadline=None, max_examples=20)
@given(
    theta_0=st.floats(0.0, 0.17),
    v_i=st.floats(0.0, 6.0),
    u_a=st.floats(-5.0, 5.0),
    v_a=st.floats(-5.0, 5.0),
    w_a=st.floats(-2.0, 2.0),
)
def test_thrust_is_the_sum_over_the_blade_elements(
    theta_0: float, v_i: float, u_a: float, v_a: float, w_a: float
) -> None:
    """Source eq. 2.30-2.33 for two blades, averaged over one turn by the trapezoidal rule (exact here)."""
    k_v = 3.0 * P.radius**2 / (2.0 * (P.radius**3 - P.cutout**3))
    turn = np.linspace(0.0, 2.0 * math.pi, 8, endpoint=False)

    def element(radius: float) -> float:
        across = OMEGA * radius - u_a * np.sin(turn) - v_a * np.cos(turn)
        through = w_a - k_v * v_i * radius
        lift = 0.5 * P.air_density * P.chord * P.lift_slope * (theta_0 * across**2 + through * across)
        return 2.0 * float(lift.mean())

    twin = P.thrust_efficiency * quad(element, P.cutout, P.radius)[0]
    assert rotor.section_angle(theta_0, OMEGA, v_i, w_a, C) < P.stall_angle - P.stall_rounding
    assert rotor.thrust(theta_0, OMEGA, v_i, u_a, v_a, w_a, C) == pytest.approx(twin, rel=1e-12, abs=1e-12)


def test_mean_inflow_over_the_disc_is_v_i() -> None:
    """Source eq. 2.28: the linear inflow has its disc mean at V_i."""
    inflow = quad(lambda r: C.inflow_gradient * 4.0 * r * 2.0 * math.pi * r, P.cutout, P.radius)[0]
    assert inflow / (math.pi * P.radius**2) == pytest.approx(4.0, rel=1e-12)


def test_torque_by_hand() -> None:
    """No thrust, alpha = 0.1: 2 eta rho c c_d Omega^2 (R^4 - r_0^4) / 4."""
    drag = 0.01449 + 0.08905 * 0.1 + 0.39076 * 0.01
    expected = 2.0 * 0.4899 * 1.2056 * 0.062 * drag * 163.363**2 * (0.725**4 - 0.12**4) / 4.0
    assert rotor.torque(0.0, 0.1, OMEGA, 0.0, 0.0, C) == pytest.approx(expected, rel=1e-14)
    with_thrust = rotor.torque(70.0, 0.1, OMEGA, 0.0, -1.0, C)
    assert with_thrust - expected == pytest.approx(70.0 / 163.363, rel=1e-12)


def test_drag_brakes_a_rotor_turning_either_way() -> None:
    assert rotor.torque(0.0, 0.05, 20.0, 0.0, 0.0, C) > 0.0
    assert rotor.torque(0.0, 0.05, -20.0, 0.0, 0.0, C) < 0.0


def test_stalled_blade_gives_no_more_thrust_but_more_drag() -> None:
    stall, knee = P.stall_angle, P.stall_rounding
    beyond = [rotor.thrust(stall + extra, OMEGA, 0.0, 0.0, 0.0, 0.0, C) for extra in (knee, 0.05, 0.1)]
    assert beyond == pytest.approx([beyond[0]] * 3, rel=1e-12)
    assert beyond[0] < rotor.thrust(stall, OMEGA, 0.0, 0.0, 0.0, 0.0, C) * 1.05
    torque = [rotor.torque(beyond[0], stall + extra, OMEGA, 0.0, 0.0, C) for extra in (knee, 0.05, 0.1)]
    assert torque[0] < torque[1] < torque[2]


def test_stall_knee_is_smooth_and_odd() -> None:
    for edge in (P.stall_angle - P.stall_rounding, P.stall_angle + P.stall_rounding):
        step = 1e-7
        before = (rotor.lost_angle(edge, C) - rotor.lost_angle(edge - step, C)) / step
        after = (rotor.lost_angle(edge + step, C) - rotor.lost_angle(edge, C)) / step
        assert before == pytest.approx(after, abs=1e-5)
    assert rotor.lost_angle(-0.3, C) == -rotor.lost_angle(0.3, C) == pytest.approx(P.stall_angle - 0.3)


def test_hover_is_far_enough_from_stall_to_be_untouched() -> None:
    assert rotor.lost_angle(rotor.section_angle(math.radians(9.69), OMEGA, 4.22, 0.0, C), C) == 0.0


def test_tail_thrust_by_hand_and_its_damping() -> None:
    omega_t = 4.0 * 163.363
    slope = 0.8671 * 1.2056 * 0.032 * 5.0
    expected = slope * 0.2 * omega_t**2 * (0.15**3 - 0.06**3) / 3.0
    assert tail_rotor.thrust(0.2, OMEGA, 0.0, 0.0, 0.0, C) == pytest.approx(expected, rel=1e-14)
    # turning right moves the tail to the left, against its thrust's reaction: less flow, more thrust
    damping = slope * 0.8612 * omega_t * (0.15**2 - 0.06**2) / 2.0
    turned = tail_rotor.thrust(0.2, OMEGA, 0.0, 0.0, 0.5, C) - expected
    assert turned == pytest.approx(0.5 * damping, rel=1e-12)


def test_only_the_physical_tail_feels_side_velocity() -> None:
    assert tail_rotor.thrust(0.2, OMEGA, 6.0, 1.0, 0.0, C) == tail_rotor.thrust(0.2, OMEGA, 6.0, 0.0, 0.0, C)
    c = constants(physical_tail())
    assert tail_rotor.thrust(0.2, OMEGA, 6.0, 1.0, 0.0, c) < tail_rotor.thrust(0.2, OMEGA, 6.0, 0.0, 0.0, c)


def test_tail_torque_by_hand() -> None:
    omega_t = 4.0 * 163.363
    drag = 0.01449 + 0.39076 * 0.04
    profile = 2.0 * 0.8671 * 1.2056 * 0.032 * drag * omega_t**2 * (0.15**4 - 0.06**4) / 4.0
    torque = tail_rotor.torque(6.8, 0.2, OMEGA, 6.3, C)
    assert torque == pytest.approx(profile + 6.8 * 6.3 / omega_t, rel=1e-13)


def test_flapping_phase_by_hand() -> None:
    """tan xi = (nu^2 - 1) / (gamma_M / 8) with nu^2 - 1 = e m_b x_b / I_b."""
    lock = 1.0679 * 1.2056 * 0.062 * 5.0 * (0.725**4 - 0.12**4) / 0.033223
    tangent = 0.041 * 0.211 * 0.4225 / 0.033223 / (lock / 8.0)
    assert C.phase_sin / C.phase_cos == pytest.approx(tangent, rel=1e-12)
    a_1, b_1 = flapping.disc_tilt(0.1, 0.0, 0.0, 0.0, 0.0, OMEGA, 0.0, 0.0, 0.0, 0.0, 0.0, C)
    cosine_squared = 1.0 / (1.0 + tangent**2)
    assert a_1 == pytest.approx(0.05469 * cosine_squared, rel=1e-12)
    assert b_1 == pytest.approx(-0.05469 * cosine_squared * tangent, rel=1e-12)


def test_flapping_phase_solves_the_blade_equation() -> None:
    """Twin: beta'' + (gamma/8) beta' + nu^2 beta = forcing, in turns of the rotor, solved for 1/rev."""
    stiffness = C.phase_sin / C.phase_cos  # (nu^2 - 1) / (gamma / 8)
    cyclic = np.array([0.02, -0.03])
    matrix = np.array([[1.0, -stiffness], [stiffness, 1.0]])
    twin = np.linalg.solve(matrix, cyclic)
    tilt = flapping.disc_tilt(
        cyclic[0] / P.bar_to_blade,
        cyclic[1] / P.bar_to_blade,
        0.0,
        0.0,
        0.0,
        OMEGA,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        C,
    )
    assert tilt == pytest.approx(twin, rel=1e-12)


def test_disc_tilts_back_in_forward_flight_and_lags_a_pitch_rate() -> None:
    forward, _ = flapping.disc_tilt(0.0, 0.0, 0.0, 0.0, 0.17, OMEGA, 4.2, 2.0, 0.0, 0.0, 0.0, C)
    pitching, _ = flapping.disc_tilt(0.0, 0.0, 0.0, 0.0, 0.17, OMEGA, 4.2, 0.0, 0.0, 1.0, 0.0, C)
    assert forward > 0.0 > pitching


def test_hub_stiffness_by_hand() -> None:
    assert flapping.hub_stiffness(OMEGA, C) == pytest.approx(0.211 * 0.4225 * 0.041 * 163.363**2, rel=1e-14)


def test_servo_rotor_time_constant_is_the_source_s() -> None:
    """k = 11.25 1/s at Omega_0 (source 11.2), and a steady tilt of k_s2p times the swash plate."""
    fall, _ = servo_rotor.flapping_rates(1.0, 0.0, 0.0, 0.0, 0.1, OMEGA, 0.0, 0.0, C)
    assert -fall == pytest.approx(11.25, abs=0.01)
    steady, _ = servo_rotor.flapping_rates(1.4199 * 0.02, 0.0, 0.02, 0.0, 0.1, OMEGA, 0.0, 0.0, C)
    assert steady == pytest.approx(0.0, abs=1e-15)


def test_resting_servo_rotor_stays_in_space() -> None:
    assert servo_rotor.flapping_rates(0.1, 0.2, 0.3, 0.4, 0.1, 0.0, 0.5, 0.6, C) == (-0.5, -0.6)


@settings(deadline=None, max_examples=50)
@given(omega=st.floats(-50.0, 300.0))
def test_reciprocal_speed_is_exact_in_flight_and_bounded_at_rest(omega: float) -> None:
    value = reciprocal_speed(omega, C.fade_speed)
    if omega >= C.fade_speed:
        assert value == 1.0 / omega
    assert 0.0 <= value <= 1.3 / C.fade_speed
    assert (value == 0.0) == (omega <= 0.0) or omega < 1e-100


def test_reciprocal_speed_is_smooth_at_the_fade_speed() -> None:
    fade, step = C.fade_speed, 1e-4
    values = [reciprocal_speed(fade + k * step, C.fade_speed) for k in (-2, -1, 0, 1, 2)]
    assert (values[2] - values[1]) / step == pytest.approx(-1.0 / fade**2, rel=1e-3)
    assert (values[0] - 2.0 * values[1] + values[2]) / step**2 == pytest.approx(2.0 / fade**3, rel=0.05)


def test_blade_that_ends_inside_its_root_is_refused() -> None:
    with pytest.raises(ValueError, match=r"tail_cutout 0\.2 m"):
        constants(HelicopterParameters(tail_cutout=0.2))
