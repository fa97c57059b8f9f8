"""Printed static gains beside ours: units and signs by hand, and what our designs make of the tables."""

from pathlib import Path

import numpy as np
import pytest

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace
from heli_common.model_file import ModelFile
from heli_control.controller_designs import design
from heli_control.published_gains import GAIN_TABLES, LOOP_SHAPING_GAINS, static_gains

MODEL = ModelFile.read(Path(__file__).parent / "data" / "hover_model.yaml")


def lag(pole: float, direct: float = 0.0) -> StateSpace:
    return StateSpace(
        ("x",), ("u", "theta", "u_ref"), ("B_1s",),
        [[pole]], [[1.0, 0.0, 0.0]], [[2.0]], [[direct, -3.0, 0.5]],
    )  # fmt: skip


def test_units_and_signs_by_hand() -> None:
    # u: 2 / 4 rad per m/s; theta: -3 rad per rad
    assert static_gains(lag(-4.0))["B_1s"] == pytest.approx({"u": -np.degrees(0.5), "theta": 3.0})
    assert static_gains(lag(-4.0), references=True)["B_1s"] == pytest.approx({"u": np.degrees(0.5)})


def test_sampled_controller_is_at_rest_at_one() -> None:
    assert static_gains(lag(0.5), 0.01)["B_1s"]["u"] == pytest.approx(-np.degrees(4.0))


def test_an_integrator_has_no_gain_at_rest() -> None:
    with pytest.raises(InputError, match="integrates"):
        static_gains(lag(0.0))


def test_every_table_has_all_commands() -> None:
    for table in GAIN_TABLES:
        assert set(table.gains) == {"B_1s", "A_1s", "theta_0", "theta_t"}
        columns = {"u", "v"} if table.references else {"theta", "phi", "u", "v", "q", "p"}
        assert set(table.gains["B_1s"]) == set(table.gains["A_1s"]) == columns
        assert set(table.gains["theta_0"]) == set(table.gains["theta_t"]) == {"w", "r"}


def test_loop_shaping_has_the_signs_and_the_size_of_table_3_5() -> None:
    made = design("ncf", MODEL)
    ours = {
        command: row
        for axis in ("horizontal", "vertical")
        for command, row in static_gains(made.axes[axis].synthesis.controller).items()
    }
    for command, row in LOOP_SHAPING_GAINS.items():
        for signal, printed in row.items():
            if abs(printed) > 0.005:
                assert np.sign(ours[command][signal]) == np.sign(printed), (command, signal)
    for command, signal in (
        ("B_1s", "theta"),
        ("A_1s", "phi"),
        ("B_1s", "u"),
        ("A_1s", "v"),
        ("theta_0", "w"),
    ):
        assert ours[command][signal] == pytest.approx(LOOP_SHAPING_GAINS[command][signal], rel=0.2)
