"""S/KS/T examined and the trade-off swept: integrators by hand, the plant of the bench, cancellation."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from heli_common.errors import InputError
from heli_common.model_file import ModelFile
from heli_control.controller_designs import design
from heli_control.flight_plants import flight_plant
from heli_control.realisation import Realisation, first_order, gain, response
from heli_control.skst_examination import rank_cases, slow_poles, with_integrals
from heli_control.trade_off import attitude_sweep
from heli_control.weights_file import default_weights

MODEL = ModelFile.read(Path(__file__).parent / "data" / "hover_model.yaml")


def test_integral_of_an_output_by_hand() -> None:
    omega = np.array([0.5, 2.0])
    whole = response(with_integrals(first_order(2.0, 3.0, 1.0), [0]), omega)
    assert whole[:, 1, 0] == pytest.approx(whole[:, 0, 0] / (1j * omega))


def test_integrators_violate_a5_of_s_ks_t_alone() -> None:
    for axis, appended in (("horizontal", {(), ("x", "y")}), ("vertical", {(), ("psi",), ("psi", "z")})):
        cases = rank_cases(
            flight_plant(MODEL, axis), default_weights("skst").axes[axis], default_weights("gst").axes[axis]
        )
        assert {case.appended for case in cases} == appended
        for case in cases:
            assert case.control.holds
            assert case.disturbance.holds == (case.scheme == "GS/T" or not case.appended)
            if not case.disturbance.holds:
                assert case.disturbance.distance < 1e-12
                assert case.disturbance.frequency == 0.0


def test_a_slow_pole_under_feedback_by_hand() -> None:
    plant = first_order(0.0, 1.0, 0.5)
    (moved,) = slow_poles(plant, gain([[-2.0]]))
    assert moved.closed == pytest.approx(-2.5)
    assert moved.moved == pytest.approx(2.0)
    # -(s + 0.5) / (s + 3) cancels it
    cancelling = Realisation(*(np.array(m) for m in ([[-3.0]], [[1.0]], [[2.5]], [[-1.0]])))
    (kept,) = slow_poles(plant, cancelling)
    assert kept.closed == pytest.approx(-0.5)
    assert kept.moved < 1e-9
    assert kept.cancellation.hidden < 1e-9


def test_s_ks_t_cancels_the_slow_pair_and_gs_t_does_not() -> None:
    for kind, cancels in (("skst", True), ("gst", False)):
        loop = design(kind, MODEL).loops["horizontal"]
        slow = [one for one in slow_poles(loop.plant, loop.feedback) if one.cancellation.pole.real < 0.0]
        assert len(slow) == 2
        assert all((one.moved < 1e-6) == cancels for one in slow)


def test_relying_on_the_angles_moves_the_paths_from_velocity_to_attitude() -> None:
    low, high = attitude_sweep(MODEL, default_weights("gst"), (0.1, 1.0))
    for angle, velocity in (("theta", "u"), ("phi", "v")):
        assert low.figures[angle] > 1.5 * high.figures[angle]
        assert high.figures[velocity] > 1.5 * low.figures[velocity]
    assert low.figures["L_u"] == pytest.approx(high.figures["L_u"], rel=0.05)


def test_what_the_sweep_refuses() -> None:
    with pytest.raises(InputError, match="has no attitude"):
        attitude_sweep(MODEL, default_weights("ncf"))
    weights = default_weights("gst")
    axis = weights.axes["horizontal"]
    silent = {name: replace(one, numerator=(0.0,)) for name, one in axis.weights["W_d"].items()}
    blind = replace(axis, weights={**axis.weights, "W_d": silent})
    (refused,) = attitude_sweep(MODEL, replace(weights, axes={**weights.axes, "horizontal": blind}), (1.0,))
    assert "A4" in refused.refused
    assert refused.figures == {}
