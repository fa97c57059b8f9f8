"""Least squares: Euler data by hand, hidden states reconstructed, refusals."""

import numpy as np
import pytest
from closed_loop_data import PERIOD, TRUTH, binary, flown, true_values
from test_identification_structures import lag

from heli_common.errors import InputError
from heli_identification.helicopter_structures import FULL
from heli_identification.least_squares import least_squares, regression_estimate
from heli_identification.records import Record
from heli_identification.structures import Parameter, Structure, Term


def integrator() -> Structure:
    """x' = a x + b u."""
    parameters = (Parameter("a", 0.0, 1.0, "1/s"), Parameter("b", 0.0, 1.0, ""))
    terms = (Term("x", "x", 1.0, (("a", 1),)), Term("x", "u", 1.0, (("b", 1),)))
    return Structure("integrator", ("x",), ("u",), ("x",), parameters, terms, ())


def euler(a: float, b: float, u: np.ndarray, period: float) -> Record:
    x = np.zeros(len(u))
    for step in range(len(u) - 1):
        x[step + 1] = x[step] + period * (a * x[step] + b * u[step] + 0.3)
    return Record("euler", period, ("u",), ("x",), u[:, None], x[:, None])


def test_euler_data_are_explained_exactly() -> None:
    record = euler(-2.0, 5.0, np.random.default_rng(1).standard_normal(100), 0.01)
    found = least_squares(integrator(), [record, record.piece(10, 60)])
    assert found.names == ("a", "b")
    assert found.values == pytest.approx([-2.0, 5.0], rel=1e-9)
    assert np.max(found.covariance) < 1e-15


def test_covariance_is_that_of_a_regression() -> None:
    """Noise on the slope that is not fed back: x is a known regressor, sigma / |x| is textbook."""
    rng, period = np.random.default_rng(2), 1.0
    x = np.cumsum(rng.choice([-1.0, 1.0], size=500))
    slope = np.append(np.diff(x), 0.0)
    structure = integrator().with_free(["b"])
    record = Record(
        "walk", period, ("u",), ("x",), (slope + 0.1 * rng.standard_normal(500))[:, None], x[:, None]
    )
    found = least_squares(structure, [record])
    u = record.u[:-1, 0] - record.u[:-1, 0].mean()
    left = np.diff(x) - np.diff(x).mean()
    gain = u @ left / (u @ u)
    error = left - gain * u
    assert found.values[0] == pytest.approx(gain, rel=1e-12)
    assert found.covariance[0, 0] == pytest.approx(error @ error / (499 - 2) / (u @ u), rel=1e-9)


def test_full_information_start_values() -> None:
    structure = FULL.with_values({"X_u": -1.07, "Y_v": -1.19})
    rng = np.random.default_rng(4)
    u, x = binary(rng, 3000), np.zeros((3000, 6))
    a, b = structure.matrices(structure.values)
    for step in range(2999):
        # held by the source's own kind of feedback, and noisy enough not to be degenerate
        u[step] -= [0.3 * x[step, 0] - 0.06 * x[step, 2], 0.3 * x[step, 1] + 0.06 * x[step, 3]]
        x[step + 1] = x[step] + PERIOD * (a @ x[step] + b @ u[step])
        if np.max(np.abs(x[step + 1])) > 1e3:
            break
    count = step
    record = Record("euler", PERIOD, structure.inputs, structure.outputs, u[:count], x[:count])
    start = structure.with_values(dict.fromkeys(structure.free_names, 0.0))
    found = least_squares(start, [record])
    assert sorted(found.names) == sorted(structure.free_names)
    truth = true_values(found.names, structure)
    assert found.values == pytest.approx(truth, rel=1e-5, abs=1e-6)


def test_servo_rotor_is_reconstructed() -> None:
    """Hidden states come from the measured rates; without noise what is left is Euler's error."""
    found = least_squares(TRUTH.with_values({"M_q": 0.0, "L_b": 1.0}), [flown(1, 20.0, noise=1e-3)])
    truth = true_values(found.names)
    index = [found.names.index(name) for name in ("M_q", "M_1", "M_a", "L_p", "L_2", "L_b")]
    assert found.values[index] == pytest.approx(truth[index], rel=0.4)


def test_as_an_estimate() -> None:
    record = flown(1, 20.0)
    found = regression_estimate(least_squares(TRUTH, [record]), [record])
    assert found.structure.free_names == found.names and len(found.names) == 18
    assert np.all(np.isfinite(found.errors)) and found.residuals[0].shape == (1999, 6)
    assert found.values[found.names.index("L_2")] == found.structure.values[TRUTH.names.index("L_2")]


def test_what_the_data_do_not_move() -> None:
    record = euler(-2.0, 5.0, np.ones(50), 0.01)
    with pytest.raises(InputError, match="x': a, b cannot be told apart"):
        least_squares(integrator(), [record])
    with pytest.raises(InputError, match="x': nothing in the data moves b"):
        least_squares(integrator(), [euler(-2.0, 5.0, np.zeros(50), 0.01)])


def test_products_of_coefficients_are_left_out() -> None:
    assert least_squares(lag(), [euler(-2.0, 5.0, np.arange(50.0), 0.01)]).names == ()
