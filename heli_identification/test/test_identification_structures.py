"""Structures: entries by hand, derivatives against differences, prior models read back."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_common.errors import InputError
from heli_common.model_file import ModelFile
from heli_identification.helicopter_structures import (
    BAR_GAIN,
    DRIVE,
    FULL,
    SCALES,
    SERVO_ROTOR,
    STRUCTURES,
    VERTICAL,
    structure_of,
)
from heli_identification.structures import Parameter, Structure, Term

HOVER = Path(__file__).parents[2] / "heli_control/test/data/hover_model.yaml"


def lag() -> Structure:
    """x' = -x / tau + (g / tau) u."""
    return Structure(
        "lag",
        ("x",),
        ("u",),
        ("x",),
        (Parameter("tau", 0.5, 0.5, "s"), Parameter("g", 3.0, 3.0, "")),
        (Term("x", "x", -1.0, (("tau", -1),)), Term("x", "u", 1.0, (("g", 1), ("tau", -1)))),
        (("g",), ("tau",)),
    )


def test_first_order_by_hand() -> None:
    a, b = lag().matrices(np.array([0.5, 3.0]))
    da, db = lag().derivatives(np.array([0.5, 3.0]))
    assert a[0, 0] == -2.0 and b[0, 0] == 6.0
    assert da[:, 0, 0].tolist() == [4.0, 0.0]  # d(-1/tau)/dtau = 1/tau^2
    assert db[:, 0, 0].tolist() == [-12.0, 2.0]  # -g/tau^2, 1/tau


def test_full_information_has_the_sources_fourteen_coefficients() -> None:
    assert len(FULL.free_names) == 14
    values = dict.fromkeys(FULL.names, 0.0) | {"X_u": -1.0, "M_2": 7.0, "L_v": -2.0}
    a, b = FULL.matrices(FULL.with_values(values).values)
    theta, phi, u, v, q, p = range(6)
    assert a[theta, q] == a[phi, p] == 1.0
    assert a[u, theta] == -9.81 and a[v, phi] == 9.81
    assert a[u, u] == -1.0 and a[p, v] == -2.0 and b[q, 1] == 7.0
    assert np.count_nonzero(a) == 6 and np.count_nonzero(b) == 1


def test_servo_rotor_follows_the_projects_signs() -> None:
    model = SERVO_ROTOR.model()
    bar, rates = model.A[6:], {name: i for i, name in enumerate(model.states)}
    assert bar[0, rates["q"]] == -1.0 and bar[1, rates["p"]] == -1.0
    assert bar[0, rates["p"]] == pytest.approx(11.2 / 163.363)
    assert bar[1, rates["q"]] == pytest.approx(-11.2 / 163.363)
    assert model.B[6, 0] == model.B[7, 1] == pytest.approx(11.2 * BAR_GAIN)
    assert "k" not in SERVO_ROTOR.free_names


@pytest.mark.parametrize("structure", STRUCTURES.values(), ids=lambda each: each.name)
def test_derivatives_are_those_of_differences(structure: Structure) -> None:
    # values that are not zero, so that every power counts
    values = np.where(structure.values == 0.0, 0.7, structure.values)
    da, db = structure.derivatives(values)
    for index, value in enumerate(values):
        step = 1e-6 * abs(value)
        ahead, behind = values.copy(), values.copy()
        ahead[index] += step
        behind[index] -= step
        for slope, which in ((da, 0), (db, 1)):
            difference = structure.matrices(ahead)[which] - structure.matrices(behind)[which]
            assert slope[index] == pytest.approx(difference / (2.0 * step), rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("name", ["full", "servo_rotor", "vertical", "vertical_full"])
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=10)
def test_a_structure_reads_its_own_model(name: str, seed: int) -> None:
    structure = structure_of(name)
    moved = structure.values * np.random.default_rng(seed).uniform(0.5, 2.0, len(structure.values))
    if "k" in structure.names:
        moved[structure.names.index("k")] = 11.2  # stands in no entry alone
    written = structure.with_values(dict(zip(structure.names, moved.tolist(), strict=True)))
    read = structure.from_model(written.model())
    assert read.values.tolist() == written.values.tolist()


def test_prior_model_of_the_bench() -> None:
    read = SERVO_ROTOR.from_model(ModelFile.read(HOVER).horizontal)
    assert read.values[read.names.index("L_p")] == pytest.approx(-34.692, abs=1e-3)
    assert read.values[read.names.index("M_a")] == pytest.approx(242.365, abs=1e-3)
    with pytest.raises(InputError, match="lacks 'w'"):
        VERTICAL.from_model(ModelFile.read(HOVER).horizontal.part(("theta",), ("B_1s",), ()))


def test_drive_has_the_steady_speed_of_its_gains() -> None:
    model = DRIVE.model()
    gain = -np.linalg.solve(model.A, model.B)[0, 0]
    values = dict(zip(DRIVE.names, DRIVE.values.tolist(), strict=True))
    assert gain == pytest.approx(values["k_U"] / values["k_Omega"])


def test_free_and_fixed() -> None:
    structure = SERVO_ROTOR.with_free(["X_u", "k"])
    assert structure.free_names == ("X_u", "k")
    assert structure.with_values({"X_u": -4.0}).scales[0] == structure.scales[0] == 1.0
    with pytest.raises(InputError, match=r"no parameter 'X_w'.*X_u"):
        SERVO_ROTOR.with_free(["X_w"])
    with pytest.raises(InputError, match=r"no structure 'heave'.*servo_rotor"):
        structure_of("heave")


def test_scales_are_the_sources() -> None:
    assert SCALES["theta_t"] == 0.25 and SCALES["q"] == 1.0 and SCALES["U_mot"] == 2.0


def test_a_structure_must_fit_together() -> None:
    parameter = Parameter("a", 1.0, 1.0, "")
    with pytest.raises(ValueError, match="no entry"):
        Structure("x", ("x",), (), ("x",), (parameter,), (Term("x", "y", 1.0),), ())
    with pytest.raises(ValueError, match="'b' is none of a"):
        Structure("x", ("x",), (), ("x",), (parameter,), (Term("x", "x", 1.0, (("b", 1),)),), ())
    assert math.isclose(lag().model().poles[0].real, -2.0)
