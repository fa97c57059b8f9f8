"""Every design on the linearised bench: shipped files, printed figures, limits, anti-windup, refusals."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from heli_common.errors import InputError
from heli_common.model_file import ModelFile
from heli_control.anti_windup import tracking_gain
from heli_control.controller_designs import DESIGNS, DesignSummary, design
from heli_control.controller_file import ControllerFile, load_controller
from heli_control.flight_plants import flight_plant
from heli_control.loop_figures import loop_figures
from heli_control.motor_controller_file import MotorControllerFile, load_motor_controller
from heli_control.motor_design import proportional_integral
from heli_control.published import PUBLISHED, PublishedFigure
from heli_control.realisation import Realisation, first_order, gain, realisation, unnamed

FLIGHT = tuple(kind for kind in DESIGNS if kind != "motor")


@pytest.fixture(scope="module")
def model() -> ModelFile:
    return ModelFile.read(Path(__file__).parent / "data" / "hover_model.yaml")


@pytest.fixture(scope="module")
def designs(model: ModelFile) -> dict[str, DesignSummary]:
    return {kind: design(kind, model) for kind in DESIGNS}


def step_response(made: DesignSummary, axis: str, seconds: float) -> Any:
    """Outputs of the SI plant under the sampled controller for a step of 0.1 on the first reference."""
    assert isinstance(made.file, ControllerFile)
    plant = flight_plant(made.model, axis).si
    law = getattr(made.file, axis).system
    x, k, seen = np.zeros(len(plant.states)), np.zeros(len(law.states)), []
    small = 20
    for _ in range(round(seconds / 0.01)):
        y = plant.C @ x
        seen.append(y)
        taken = {**dict(zip(plant.outputs, y, strict=True)), law.inputs[-2]: 0.1, law.inputs[-1]: 0.0}
        inputs = np.array([taken[name] for name in law.inputs])
        u = law.C @ k + law.D @ inputs
        k = law.A @ k + law.B @ inputs
        for _ in range(small):
            half = x + 0.5 * 0.01 / small * (plant.A @ x + plant.B @ u)
            x = x + 0.01 / small * (plant.A @ half + plant.B @ u)
    return np.array(seen)


def test_shipped_controllers_are_what_the_designs_give(designs: dict[str, DesignSummary]) -> None:
    for kind in FLIGHT:
        made, shipped = designs[kind].file, load_controller(kind)
        assert isinstance(made, ControllerFile)
        assert made.plant_hash == shipped.plant_hash
        for axis in ("horizontal", "vertical"):
            ours, theirs = getattr(made, axis), getattr(shipped, axis)
            assert ours.system.inputs == theirs.system.inputs
            # states may be turned by another BLAS; what goes in and out may not
            omega = np.geomspace(0.1, 200.0, 30)
            z = np.exp(1j * omega * 0.01)
            for one, other in zip(responses(ours.system, z), responses(theirs.system, z), strict=True):
                np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-7 * np.abs(other).max())
    motor = designs["motor"].file
    assert isinstance(motor, MotorControllerFile)
    assert motor.parameters.gain == pytest.approx(load_motor_controller("motor").parameters.gain, rel=1e-6)


def responses(system: Any, z: Any) -> list[Any]:
    n = len(system.states)
    return [system.C @ np.linalg.solve(one * np.eye(n) - system.A, system.B) + system.D for one in z]


def test_seven_of_ten_printed_loop_figures_are_reproduced(designs: dict[str, DesignSummary]) -> None:
    rows = [row for made in designs.values() for row in made.published]
    assert len(rows) == len(PUBLISHED) == 28
    missed = [row for row in rows if not row.reproduced]
    assert len(missed) <= 0.3 * len(rows)
    assert all(row.published.reason for row in missed)
    gamma = next(row for row in rows if row.published.name == "gamma_min")
    assert gamma.reproduced


def test_flight_loops_keep_the_limits_of_the_sensitivity(designs: dict[str, DesignSummary]) -> None:
    for kind in FLIGHT:
        for figures in designs[kind].figures.values():
            assert figures["|S_u|"] < 6.0


@pytest.mark.parametrize("kind", FLIGHT)
def test_sampled_controllers_bring_the_velocity_to_its_reference(
    kind: str, designs: dict[str, DesignSummary]
) -> None:
    seen = step_response(designs[kind], "horizontal", 6.0)
    outputs = flight_plant(designs[kind].model, "horizontal").si.outputs
    at_rest = seen[-50:, outputs.index("u")].mean() / 0.1
    wanted = {"gst2": 0.8, "ncf2": 0.7}.get(kind, 1.0)
    assert at_rest == pytest.approx(wanted, abs=0.12)
    assert np.abs(seen[:, outputs.index("v")]).max() < 0.02


@pytest.mark.parametrize("kind", FLIGHT)
def test_states_follow_the_applied_command_without_growing(
    kind: str, designs: dict[str, DesignSummary]
) -> None:
    file = designs[kind].file
    assert isinstance(file, ControllerFile)
    for axis in (file.horizontal, file.vertical):
        while_limited = axis.system.A - axis.anti_windup @ axis.system.C
        assert np.abs(np.linalg.eigvals(while_limited)).max(initial=0.0) < 1.0


def test_tracking_of_an_integrator_by_hand() -> None:
    # x+ = x + u, y = x: with little output noise E is nearly 1, so that x+ is the applied command
    from heli_common.linear_model import StateSpace

    system = StateSpace(("x",), ("u",), ("y",), [[1.0]], [[1.0]], [[1.0]], [[0.0]])
    found = tracking_gain(system, np.ones(1), np.ones(1))
    assert 0.9 < found[0, 0] <= 1.0


def test_motor_is_a_pi_controller_below_its_crossover(designs: dict[str, DesignSummary]) -> None:
    figures = designs["motor"].figures["drive"]
    assert figures["crossover"] == pytest.approx(13.0, rel=0.1)
    assert figures["apart"] < 0.15


def test_pi_of_a_pi_by_hand() -> None:
    omega = np.geomspace(0.1, 10.0, 20)
    gain_, time = proportional_integral(omega, 0.3 * (1.0 + 1.0 / (1j * omega * 0.5)))
    assert (gain_, time) == (pytest.approx(0.3), pytest.approx(0.5))


def test_loop_figures_of_an_integrator_by_hand() -> None:
    # L = 5 / s: crosses at 5 rad/s; S = s / (s + 5) passes -3 dB at 5 rad/s; no peaks
    figures = loop_figures(first_order(0.0, 1.0, 1e-9), gain(-5.0), ("y",))
    assert figures["L_u"] == pytest.approx(5.0, rel=1e-3)
    assert figures["y"] == pytest.approx(5.0, rel=1e-3)
    assert figures["S_u"] == pytest.approx(5.0, rel=1e-2)
    assert figures["|S_u|"] == pytest.approx(0.0, abs=1e-3)


def test_figures_that_count_as_reproduced() -> None:
    def row(criterion: str, value: float) -> PublishedFigure:
        return PublishedFigure("lq", "vertical", "w", value, "", criterion)

    assert row("within 15 %", 10.0).reproduced(11.4) and not row("within 15 %", 10.0).reproduced(11.6)
    assert row("within 1 dB", 2.0).reproduced(2.9) and not row("within 1 dB", 2.0).reproduced(3.1)
    assert row("at most", 2.2).reproduced(0.5) and not row("at most", 2.2).reproduced(2.3)
    assert row("within 25 %", 2.43).reproduced(3.0) and not row("within 25 %", 2.43).reproduced(3.1)
    assert not row("at most", 2.2).reproduced(None)


def test_model_without_a_signal_is_refused(model: ModelFile) -> None:
    from dataclasses import replace

    block = model.horizontal
    shorter = block.part(block.states, block.inputs, ("theta", "phi", "u", "v", "q"))
    with pytest.raises(InputError, match="lacks 'p'"):
        design("gst", replace(model, horizontal=shorter))
    with pytest.raises(InputError, match="drive: is missing"):
        design("motor", replace(model, full=None))


def test_weights_that_cannot_be_met_are_refused_with_the_reason(model: ModelFile, tmp_path: Path) -> None:
    path = tmp_path / "weights.yaml"
    path.write_text("format: heli_weights/1\nkind: gst\nhorizontal: {W_u: {B_1s: 0.0}}\n")
    with pytest.raises(InputError, match=r"gst\.horizontal: A3 \(D12\): not of full column rank"):
        design("gst", model, path)


def test_controller_of_another_model(model: ModelFile) -> None:
    """Any plant of the same type: 20 % more control, rates damped half as much."""
    from dataclasses import replace

    block = model.horizontal
    changed = replace(block, B=1.2 * block.B, A=block.A - 0.0 * block.A)
    made = design("ncf", replace(model, horizontal=changed))
    assert isinstance(made.file, ControllerFile)
    assert made.file.plant_hash != model.plant_hash
    assert made.figures["horizontal"]["|S_u|"] < 6.0


def test_feedback_part_of_a_controller_goes_there_and_back(model: ModelFile) -> None:
    plant = flight_plant(model, "vertical")
    rng = np.random.default_rng(2)
    scaled: Realisation = realisation(
        -np.eye(3), rng.normal(size=(3, 2)), rng.normal(size=(2, 3)), rng.normal(size=(2, 2))
    )
    made = plant.controller(scaled, separate_references=False)
    for one, other in zip(plant.feedback(made), scaled, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12)
    # 1DOF takes y - r
    np.testing.assert_allclose(unnamed(made).B[:, 2:], -unnamed(made).B[:, :2])
