"""The running estimate on a linear helicopter of its own structure."""

import numpy as np

from heli_common.rotations import Euler
from heli_common.timing import CONTROL_PERIOD
from heli_common.topics import ESTIMATED
from heli_common.vehicle_state import VehicleState
from heli_identification.running_estimate import UNKNOWN_ERROR, WINDOW, EstimateParameters, RunningEstimate

TRUTH = dict(
    zip(
        ESTIMATED,
        (-1.0, 0.5, -14.0, 150.0, -40.0, 0.4, 0.8, -0.6, -35.0, 30.0, 380.0, -2.0),
        strict=True,
    )
)
SUBSTEPS = 50


def fly(estimate: RunningEstimate, samples: int, delay: int, noise: float, seed: int = 2) -> None:
    """Rates follow eq. 2.82 exactly (Euler with fine steps); speeds are given, commands held and delayed."""
    rng = np.random.default_rng(seed)
    t = TRUTH
    q = p = 0.0
    commands = np.repeat(0.01 * rng.standard_normal((samples // 20 + 2, 2)), 20, axis=0)
    for n in range(samples):
        u, v = 0.1 * np.sin(0.9 * n * CONTROL_PERIOD), 0.1 * np.cos(0.7 * n * CONTROL_PERIOD)
        seen = noise * rng.standard_normal(2)
        state = VehicleState((0, 0, 0), Euler(0, 0, 0), (u, v, 0.0), (p + seen[0], q + seen[1], 0.0))
        estimate.step(state, (*commands[n], 0.1, 0.2), True)
        b_1s, a_1s = commands[max(0, n - delay)]
        for _ in range(SUBSTEPS):
            step = CONTROL_PERIOD / SUBSTEPS
            pitch = t["M_u"] * u + t["M_v"] * v + t["M_q"] * q + t["M_1"] * b_1s + t["M_2"] * a_1s + t["M_0"]
            roll = t["L_u"] * u + t["L_v"] * v + t["L_p"] * p + t["L_1"] * b_1s + t["L_2"] * a_1s + t["L_0"]
            q, p = q + step * pitch, p + step * roll


def test_the_coefficients_of_a_helicopter_of_this_structure_are_found() -> None:
    estimate = RunningEstimate(EstimateParameters(command_delay=0.02))
    fly(estimate, 4000, delay=2, noise=1e-6)
    found = dict(zip(ESTIMATED, estimate.estimate.tolist(), strict=True))
    for name in ("M_q", "M_1", "M_2", "L_p", "L_2"):  # means over 0.1 s by the trapezoidal rule
        assert np.isclose(found[name], TRUTH[name], rtol=0.06), (name, found[name])
    assert np.all(estimate.standard_error < 0.05 * np.abs(list(TRUTH.values())) + 0.7)


def test_the_wrong_delay_is_seen_as_error() -> None:
    right, wrong = (RunningEstimate(EstimateParameters(command_delay=delay)) for delay in (0.02, 0.12))
    fly(right, 2000, delay=2, noise=1e-6)
    fly(wrong, 2000, delay=2, noise=1e-6)
    assert np.all(wrong.standard_error > 2.0 * right.standard_error)


def test_more_noise_is_claimed_as_more_error() -> None:
    calm, loud = RunningEstimate(EstimateParameters()), RunningEstimate(EstimateParameters())
    fly(calm, 2000, delay=3, noise=1e-3)
    fly(loud, 2000, delay=3, noise=2e-2)
    assert np.all(loud.standard_error > 1.5 * calm.standard_error)


def test_without_excitation_nothing_is_learnt() -> None:
    estimate = RunningEstimate(EstimateParameters())
    state = VehicleState((0, 0, 0), Euler(0, 0, 0), (0.1, 0.0, 0.0), (0.2, 0.1, 0.0))
    for _ in range(500):
        estimate.step(state, (0.01, 0.02), False)
    assert not estimate.estimate.any()
    assert (estimate.standard_error == UNKNOWN_ERROR).all()
    for _ in range(WINDOW):  # a window has eleven samples, the first and the last shared
        estimate.step(state, (0.01, 0.02), True)
    assert (estimate.standard_error == UNKNOWN_ERROR).all()
