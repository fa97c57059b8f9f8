"""The position law in a linear loop: by hand, and against the law itself."""

from pathlib import Path

import numpy as np
import pytest

from heli_common.errors import InputError
from heli_common.model_file import ModelFile
from heli_common.rotations import Euler
from heli_common.vehicle_state import VehicleState
from heli_control.controller_file import load_controller
from heli_control.position_control import PositionLaw, PositionParameters
from heli_control.position_loop import with_position_law, with_positions
from heli_control.state_space import DiscreteBlock

MODEL = ModelFile.read(Path(__file__).parent / "data" / "hover_model.yaml")


def test_positions_are_integrals_of_velocities() -> None:
    plant = with_positions(MODEL.horizontal)
    assert plant.outputs[-2:] == plant.states[-2:] == ("x", "y")
    state = np.arange(1.0, 11.0)
    slope = plant.A @ state
    assert slope[8] == state[plant.states.index("u")]
    assert slope[9] == state[plant.states.index("v")]
    np.testing.assert_array_equal(slope[:8], MODEL.horizontal.A @ state[:8])
    assert with_positions(MODEL.vertical).outputs[-2:] == ("z", "psi")


def test_controller_with_the_law_is_the_law_before_the_controller() -> None:
    parameters = PositionParameters()
    inner = load_controller("lq").horizontal.system
    outer = with_position_law(inner, parameters)
    assert "u_ref" not in outer.inputs
    assert outer.inputs[-2:] == ("x", "y")
    one, two, law = DiscreteBlock(inner), DiscreteBlock(outer), PositionLaw(parameters)
    rng = np.random.default_rng(3)
    place = (0.0, 0.0)
    # the law expects what it sees first: it begins at its reference
    law.step(_at(place), (0.0, 0.0, 0.0), 0.0)
    for _ in range(60):
        place = tuple(0.02 * rng.standard_normal(2))
        u_ref, v_ref, _, _ = law.step(_at(place), (0.0, 0.0, 0.0), 0.0)
        measured = dict(zip(("theta", "phi", "u", "v", "p", "q"), rng.standard_normal(6), strict=True))
        signals = measured | {"u_ref": u_ref, "v_ref": v_ref, "x": place[0], "y": place[1]}
        np.testing.assert_allclose(
            one.step([signals[name] for name in one.inputs]),
            two.step([signals[name] for name in two.inputs]),
            atol=1e-12,
        )


def _at(place: tuple[float, ...]) -> VehicleState:
    zero = (0.0, 0.0, 0.0)
    return VehicleState((place[0], place[1], 0.0), Euler(0.0, 0.0, 0.0), zero, zero)


def test_a_controller_without_references_is_refused() -> None:
    with pytest.raises(InputError, match="no reference among the inputs"):
        with_position_law(MODEL.horizontal, PositionParameters())
