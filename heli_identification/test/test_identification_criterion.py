"""The predictor by hand, and gradient, information and scores of the likelihood against differences."""

from dataclasses import replace

import numpy as np
import pytest
from closed_loop_data import PERIOD, TRUTH, flown, servo_rotor_twin
from test_identification_structures import lag

from heli_identification.closed_loop import ClosedLoop, driven_by_external
from heli_identification.criterion import Criterion
from heli_identification.helicopter_structures import VERTICAL
from heli_identification.innovations import Predictor
from heli_identification.parametrisation import Noise, Parametrisation, disturbed_states
from heli_identification.records import Record, data_hash
from heli_identification.sampling import Hold
from heli_identification.start_values import start_vector


def test_predictor_by_hand() -> None:
    predictor = Predictor(
        A=np.array([[0.5]]),
        B=np.array([[2.0]]),
        K=np.array([[0.25]]),
        drift=np.array([1.0]),
        seen=np.array([0]),
    )
    errors, fine = predictor.residuals(np.array([[1.0], [0.0]]), np.array([[5.0], [4.0]]), np.array([1.0]))
    # e0 = 5 - 1 = 4; x1 = 0.5 + 2 + 1 + 0.25 * 4 = 4.5; e1 = 4 - 4.5
    assert fine and errors[:, 0].tolist() == [4.0, -0.5]


def test_a_diverging_predictor_says_so() -> None:
    predictor = Predictor(np.array([[10.0]]), np.zeros((1, 1)), np.zeros((1, 1)), np.zeros(1), np.array([0]))
    _, fine = predictor.residuals(np.zeros((40, 1)), np.zeros((40, 1)), np.ones(1))
    assert not fine


def check(criterion: Criterion, vector: np.ndarray, whole: bool) -> None:
    """Scores sum to the gradient; both are what differences of the cost say."""
    found = criterion.evaluate(vector, scores=True)
    total = np.sum([score.sum(axis=0) for score in found.scores], axis=0)
    assert found.gradient == pytest.approx(total, rel=1e-6, abs=1e-6 * np.max(np.abs(total)))
    assert found.information == pytest.approx(found.information.T)
    size = float(np.max(np.abs(found.gradient)))
    for index in range(0, criterion.size, 1 if whole else 3):
        step = 1e-5
        ahead, behind = vector.copy(), vector.copy()
        ahead[index] += step
        behind[index] -= step
        difference = (criterion.cost(ahead) - criterion.cost(behind)) / (2.0 * step)
        assert found.gradient[index] == pytest.approx(difference, rel=2e-4, abs=1e-5 * size)


def scattered(criterion: Criterion) -> np.ndarray:
    """Start values moved a little, so that no derivative is small by accident."""
    vector = start_vector(criterion)
    return vector + 0.02 * np.random.default_rng(3).standard_normal(len(vector))


@pytest.mark.parametrize("noise", Noise)
@pytest.mark.parametrize("hold", Hold)
def test_gradient_first_order(noise: Noise, hold: Hold) -> None:
    rng = np.random.default_rng(1)
    pieces = [
        Record("data", 0.1, ("u",), ("x",), rng.standard_normal((50, 1)), rng.standard_normal((50, 1)))
        for _ in range(2)
    ]
    criterion = Criterion(Parametrisation(lag(), noise, 0.1, hold), pieces)
    check(criterion, scattered(criterion), whole=True)


@pytest.mark.parametrize("noise", Noise)
def test_gradient_servo_rotor(noise: Noise) -> None:
    record = flown(1, 3.0)
    criterion = Criterion(Parametrisation(TRUTH, noise, PERIOD, Hold.ZERO), [record])
    check(criterion, scattered(criterion), whole=False)


def test_gradient_with_a_given_weighting() -> None:
    record = flown(1, 2.0)
    criterion = Criterion(Parametrisation(TRUTH, Noise.KALMAN, PERIOD, Hold.ZERO), [record], np.eye(6))
    check(criterion, scattered(criterion), whole=False)


@pytest.mark.parametrize("joint", [False, True])
@pytest.mark.parametrize("delay", [0, 1, 2])
def test_gradient_closed_loop(joint: bool, delay: int) -> None:
    twin = servo_rotor_twin()
    loop = ClosedLoop(TRUTH, twin.feedback, PERIOD, delay, joint=joint)
    record = driven_by_external(flown(1, 2.0), twin.feedback.outputs, joint=joint)
    weighting = np.diag(np.maximum(np.var(record.y, axis=0), 1e-9)) if joint else None
    criterion = Criterion(loop, [record], weighting)
    check(criterion, scattered(criterion), whole=False)


def test_noise_acts_where_coefficients_do() -> None:
    assert [TRUTH.states[index] for index in disturbed_states(TRUTH)] == ["u", "v", "q", "p"]
    assert [VERTICAL.states[index] for index in disturbed_states(VERTICAL)] == ["w", "r"]


def test_hash_knows_every_number() -> None:
    record = flown(1, 0.5)
    moved = replace(record, y=record.y + np.eye(len(record), 6) * 1e-12)
    assert data_hash([record]) == data_hash([replace(record, name="other")])
    assert len({data_hash([record]), data_hash([moved]), data_hash([record.piece(0, 49)])}) == 3
