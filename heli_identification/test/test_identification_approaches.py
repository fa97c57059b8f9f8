"""Projection, indirect and joint approach: what they find, and what they refuse."""

from dataclasses import replace

import numpy as np
import pytest
from closed_loop_data import TRUTH, flown, servo_rotor_twin, true_values

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace
from heli_identification.closed_loop import ClosedLoop, driven_by_external
from heli_identification.indirect import indirect
from heli_identification.prediction_error import Search
from heli_identification.projection import lag_groups, project, projection
from heli_identification.records import Record

AT_ONCE = Search(stepwise=False)
FAST = ["M_q", "M_1", "L_p", "L_2", "M_a", "L_b"]


def fast_errors(found: object) -> np.ndarray:
    """Relative errors of the coefficients of the fast motion."""
    index = [found.names.index(name) for name in FAST]
    return found.values[index] / true_values(tuple(FAST)) - 1.0


def test_lag_groups_by_hand() -> None:
    assert lag_groups(3, 2) == [-2, -1, 0, 1, 2, 3, 4]
    groups = lag_groups(600, 20)
    widths = np.diff(groups)
    assert groups[0] == -20 and groups[-1] == 601
    assert np.all(widths[:36] == 1) and np.all(np.diff(widths[:-1]) >= 0)


def test_projection_takes_out_what_feedback_added() -> None:
    """u = r delayed plus noise: the projection is the delayed r, up to what chance lets through."""
    rng = np.random.default_rng(1)
    r, noise = rng.standard_normal((4000, 1)), rng.standard_normal((4000, 1))
    u = 0.5 * np.vstack((np.zeros((3, 1)), r[:-3])) + noise
    found = project(Record("x", 0.01, ("u",), ("x",), u, u, r), behind=0.5)
    assert found.share[0] == pytest.approx(0.2, abs=0.05)
    wanted = u[50:-20] - noise[50:-20]
    assert np.sqrt(np.mean((found.record.u - wanted) ** 2)) < 0.2


def test_projection_finds_the_fast_motion() -> None:
    found = projection(TRUTH, [flown(1, 30.0, noise=0.3)], search=AT_ONCE)
    assert found.converged and np.max(np.abs(fast_errors(found))) < 0.05


@pytest.mark.parametrize("joint", [False, True])
def test_indirect_and_joint_find_the_plant(joint: bool) -> None:
    feedback = servo_rotor_twin().feedback
    found = indirect(TRUTH, [flown(2, 20.0, noise=0.3)], feedback, delay=1, joint=joint, search=AT_ONCE)
    assert found.converged and np.max(np.abs(fast_errors(found))) < 0.05
    assert np.max(np.abs(found.values - true_values(found.names)) / found.errors) < 5.0


def test_a_delay_that_is_not_the_flown_one_spoils_the_indirect_approach() -> None:
    record, feedback = flown(2, 20.0, noise=0.3), servo_rotor_twin().feedback
    right = indirect(TRUTH, [record], feedback, delay=1, search=AT_ONCE)
    wrong = indirect(TRUTH, [record], feedback, delay=4, search=AT_ONCE)
    assert np.linalg.norm(fast_errors(wrong)) > 3.0 * np.linalg.norm(fast_errors(right))


def test_loop_predicts_the_flight_exactly() -> None:
    """Without noise the loop with dynamic feedback, delay and u - r gives back what was flown."""
    gain = servo_rotor_twin().feedback
    names = ("s", "t")
    dynamic = StateSpace(
        names, gain.inputs, gain.outputs, 0.5 * np.eye(2), 0.1 * gain.D, 0.2 * np.eye(2), gain.D
    )
    twin = replace(servo_rotor_twin(0.0), feedback=dynamic, delay=2)
    rng = np.random.default_rng(5)
    r = 0.01 * rng.standard_normal((300, 2))
    record = driven_by_external(twin.fly(r, rng), dynamic.outputs, joint=True)
    loop = ClosedLoop(TRUTH, dynamic, 0.01, 2, joint=True)
    point = loop.point(true_values(TRUTH.free_names))
    predictor, start = loop.predictor(point, np.zeros(loop.local))
    errors, fine = predictor.residuals(record.u, record.y, start)
    assert fine and np.max(np.abs(errors)) < 1e-9


def test_refusals() -> None:
    record = flown(1, 3.0)
    bare = replace(record, r=None)
    feedback = servo_rotor_twin().feedback
    with pytest.raises(InputError, match="no external signal"):
        projection(TRUTH, [bare])
    with pytest.raises(InputError, match="no external signal"):
        indirect(TRUTH, [replace(record, r=np.zeros_like(record.u))], feedback)
    with pytest.raises(InputError, match=r"samples for .* coefficients of the projection"):
        project(record.piece(0, 200), behind=1.0)
    wrong = feedback.part((), ("theta",), ("B_1s",))
    strange = StateSpace((), ("z",), ("B_1s",), wrong.A, wrong.B, wrong.C, wrong.D)
    with pytest.raises(InputError, match="the feedback uses 'z'"):
        indirect(TRUTH, [record], strange)
    wild = StateSpace(
        (), feedback.inputs, feedback.outputs, feedback.A, feedback.B, feedback.C, -9.0 * feedback.D
    )
    with pytest.raises(InputError, match="closed loop of prior model and given controller is unstable"):
        indirect(TRUTH, [record], wild)
