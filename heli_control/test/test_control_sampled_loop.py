"""The loop as it flies: by hand, against a fine-step twin, against the frequency response, friction."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace
from heli_common.model_file import ModelFile
from heli_control.lq import (
    HORIZONTAL_INPUTS,
    HORIZONTAL_STATES,
    LqWeights,
)
from heli_control.lq_axis import controller_block, design_axis
from heli_control.margins import loop_margins, uniform_margins
from heli_control.realisation import first_order, named
from heli_control.rig_plant import MEASURED_SPEED, with_friction, with_speed_sensor
from heli_control.sampled_loop import (
    LoopTiming,
    SampledLoop,
    closed_matrix,
    loop_response,
    opened,
    sampled_margins,
    spectral_radius,
)

MODEL = ModelFile.read(Path(__file__).parent / "data" / "hover_model.yaml")
MS = 1_000_000


def gain_block(value: float) -> StateSpace:
    empty = np.zeros((0, 0))
    return StateSpace(
        (), ("y", "y_ref"), ("u",), empty, empty.reshape(0, 2), empty.reshape(1, 0), [[value, 9.0]]
    )


def lq_loop(timing: LoopTiming | None = None) -> SampledLoop:
    weights = LqWeights()
    design = design_axis(
        MODEL.horizontal,
        HORIZONTAL_STATES,
        HORIZONTAL_INPUTS,
        np.array([getattr(weights, name) for name in HORIZONTAL_STATES]),
        weights.effort * np.array([1.0, weights.rho]),
        weights.command_delay,
    )
    plant = with_friction(MODEL.horizontal, {"u": 7.7, "v": 8.6}, 7.3)
    return SampledLoop(plant, controller_block(design).system, timing or LoopTiming())


def twin(loop: SampledLoop, start: np.ndarray, frames: int, step_ns: int) -> np.ndarray:
    """The same flight by Runge-Kutta steps and a list of stamped commands; samples of the plant's states."""
    plant, controller, timing = loop.plant, loop.controller, loop.timing
    m = len(controller.outputs)
    columns = [plant.inputs.index(name) for name in controller.outputs]
    taken = [plant.outputs.index(name) for name in loop.measured]
    fed = [controller.inputs.index(name) for name in loop.measured]
    x, angle, rate = start.copy(), np.zeros(m), np.zeros(m)
    x_k, sent, latched, active = np.zeros(len(controller.states)), [], [], np.zeros(m)
    seen = []

    def slope(
        x: np.ndarray, angle: np.ndarray, rate: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        turn = (
            loop.servo_bandwidth**2 * (active - angle)
            - 2.0 * loop.servo_damping * loop.servo_bandwidth * rate
        )
        return plant.A @ x + plant.B[:, columns] @ angle, rate, turn

    for clock in range(0, frames * timing.pulse_ns, step_ns):
        if clock % timing.pulse_ns == 0:
            seen.append(x.copy())
        if clock % timing.control_ns == 0:
            y = np.zeros(len(controller.inputs))
            y[fed] = (plant.C @ x + plant.D[:, columns] @ angle)[taken]
            sent.append((clock, controller.C @ x_k + controller.D @ y))
            x_k = controller.A @ x_k + controller.B @ y
        if clock % timing.pulse_ns == timing.latch_ns:
            there = [command for stamp, command in sent if stamp + timing.latency_ns <= clock]
            latched.append((clock, there[-1] if there else np.zeros(m)))
        for instant, frame in latched:
            if instant + timing.dead_ns == clock:
                active = frame
        h, state = step_ns * 1e-9, (x, angle, rate)
        one = slope(*state)
        two = slope(*(s + 0.5 * h * d for s, d in zip(state, one, strict=True)))
        three = slope(*(s + 0.5 * h * d for s, d in zip(state, two, strict=True)))
        four = slope(*(s + h * d for s, d in zip(state, three, strict=True)))
        x, angle, rate = (
            s + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
            for s, a, b, c, d in zip(state, one, two, three, four, strict=True)
        )
    return np.array(seen)


def test_integrator_by_hand() -> None:
    # y' = u, u = -g y held for 20 ms from 5 ms after the sample; a servo too fast to matter
    plant = named(first_order(0.0, 1.0, 0.0), ("u",), ("y",), "x")
    loop = SampledLoop(plant, gain_block(-20.0), servo_bandwidth=1e6)
    # y(n+1) = y(n) + 5 ms u(n-1) + 15 ms u(n): z^2 - z + 20 (0.015 z + 0.005) = 0
    expected = np.abs(np.roots([1.0, 20.0 * 0.015 - 1.0, 20.0 * 0.005])).max()
    assert spectral_radius(opened(loop)) == pytest.approx(expected, rel=1e-4)
    # at the limit z = e^jw of z^2 + (0.015 g - 1) z + 0.005 g = 0: the product of the roots is 1 at g = 200,
    # z = -1 is a root at 2 - 0.015 g + 0.005 g = 0, g = 200 too
    margins = sampled_margins(loop)
    assert margins.gain_up_db == pytest.approx(20.0 * math.log10(200.0 / 20.0), abs=0.005)
    assert math.isinf(margins.gain_down_db)


def test_ages_of_commands() -> None:
    assert LoopTiming().age == 0
    assert LoopTiming(latency_ns=6 * MS).age == 1
    assert LoopTiming(latency_ns=105 * MS).age == 10
    assert LoopTiming(latch_ns=15 * MS).age == 0
    assert LoopTiming(latch_ns=15 * MS, latency_ns=16 * MS).age == 2


@pytest.mark.parametrize(
    "timing",
    [
        LoopTiming(),
        LoopTiming(dead_ns=7 * MS),
        LoopTiming(dead_ns=15 * MS),
        LoopTiming(dead_ns=32 * MS),
        LoopTiming(latency_ns=16 * MS),
        LoopTiming(latch_ns=15 * MS, latency_ns=3 * MS, dead_ns=20 * MS),
    ],
)
def test_lifted_loop_flies_as_the_fine_step_twin(timing: LoopTiming) -> None:
    loop = lq_loop(timing)
    start = np.array([0.05, -0.03, 0.1, 0.2, 0.0, 0.0, 0.0, 0.0])
    frames = 12
    flown = twin(loop, start, frames, MS // 4)
    frame = opened(loop)
    z = np.zeros(frame.order)
    z[:8] = start
    for row in flown:
        np.testing.assert_allclose(z[:8], row, atol=2e-6)
        z = closed_matrix(frame) @ z
    assert np.abs(flown[-1] - flown[0]).max() > 1e-2


def test_gain_margin_of_the_eigenvalues_is_that_of_the_frequency_response() -> None:
    loop = lq_loop()
    margins = sampled_margins(loop)
    assert margins.spectral_radius < 1.0
    omega = np.append(np.geomspace(1e-3, math.pi / 0.02, 4000)[:-1], math.pi / 0.02)
    by_response = uniform_margins(loop_response(loop, omega), omega)
    assert margins.gain_up_db == pytest.approx(by_response.gain_up_db, abs=0.02)
    assert margins.gain_down_db == pytest.approx(by_response.gain_down_db, abs=0.02)
    # a dead time is no phase per frame exactly, because the frame holds; nearly so well below 50 Hz
    assert margins.delay_ms == pytest.approx(by_response.delay_ms, rel=0.1)
    for beyond in (-0.01, 0.01):
        factor = 10.0 ** ((margins.gain_up_db + beyond) / 20.0)
        assert (spectral_radius(opened(loop), factor) < 1.0) is (beyond < 0.0)


def test_a_plant_that_needs_control_has_a_lower_margin() -> None:
    # y' = y + u with u = -g y: g must stay above 1, whatever the sampling
    plant = named(first_order(0.0, 1.0, -1.0), ("u",), ("y",), "x")
    margins = sampled_margins(SampledLoop(plant, gain_block(-4.0)))
    assert margins.gain_down_db == pytest.approx(20.0 * math.log10(4.0), abs=1e-4)


def test_delay_margin_is_where_the_late_loop_is_lost() -> None:
    loop = lq_loop()
    delay = sampled_margins(loop).delay_ms
    for share, stable in ((0.98, True), (1.02, False)):
        late = replace(loop, timing=LoopTiming(dead_ns=round(share * delay * MS)))
        assert (spectral_radius(opened(late)) < 1.0) is stable


def test_one_channel_at_a_time() -> None:
    loop = lq_loop()
    omega = np.append(np.geomspace(1e-3, math.pi / 0.02, 4000)[:-1], math.pi / 0.02)
    channels = loop_margins(loop_response(loop, omega), omega, loop.controller.outputs).channels
    for index, name in enumerate(loop.controller.outputs):
        for beyond, stable in ((-0.05, True), (0.05, False)):
            factor = np.ones(2)
            factor[index] = 10.0 ** ((channels[name].gain_up_db + beyond) / 20.0)
            assert (spectral_radius(opened(loop), factor) < 1.0) is stable


def test_a_loop_that_is_not_stable_has_no_margins() -> None:
    plant = named(first_order(0.0, 1.0, 0.0), ("u",), ("y",), "x")
    with pytest.raises(ValueError, match="the sampled loop is not stable: spectral radius 1"):
        sampled_margins(SampledLoop(plant, gain_block(1.0)))


def test_inner_controller_by_hand() -> None:
    # s' = v, v = -g s acts from 5 ms after the sample on, without frames; the outer loop stands still
    names = ("u", "v"), ("y", "s")
    plant = StateSpace(("y", "s"), *names, -np.diag([1.0, 0.0]), np.eye(2), np.eye(2), np.zeros((2, 2)))
    empty = np.zeros((0, 0))
    g = 30.0
    inner = StateSpace((), ("s",), ("v",), empty, empty.reshape(0, 1), empty.reshape(1, 0), [[-g]])
    loop = SampledLoop(plant, gain_block(0.0), inner=inner)
    # s(n+1) = s(n) - 5 ms g (s(n-1) + s(n)), twice per frame
    expected = np.abs(np.roots([1.0, 0.005 * g - 1.0, 0.005 * g])).max() ** 2
    outer = math.exp(-0.02)
    assert spectral_radius(opened(loop)) == pytest.approx(max(expected, outer), rel=1e-9)
    eigenvalues = np.abs(np.linalg.eigvals(closed_matrix(opened(loop))))
    assert np.abs(eigenvalues - expected).min() < 1e-9
    # a period later: s(n+1) = s(n) - 5 ms g (s(n-2) + s(n-1))
    late = replace(loop, timing=LoopTiming(inner_latency_ns=15 * MS))
    expected = np.abs(np.roots([1.0, -1.0, 0.005 * g, 0.005 * g])).max() ** 2
    eigenvalues = np.abs(np.linalg.eigvals(closed_matrix(opened(late))))
    assert np.abs(eigenvalues - expected).min() < 1e-9
    with pytest.raises(InputError, match="'z' is no output of the plant"):
        replace(loop, inner=replace(inner, inputs=("z",)))
    with pytest.raises(ValueError, match="inner_latency_ns -1; allowed"):
        LoopTiming(inner_latency_ns=-1)


def test_friction() -> None:
    plant = with_friction(MODEL.horizontal, {"u": 7.3, "v": 14.6}, 7.3)
    change = plant.A - MODEL.horizontal.A
    assert change[2, 2] == pytest.approx(-1.0)
    assert change[3, 3] == pytest.approx(-2.0)
    assert np.count_nonzero(change) == 2
    with pytest.raises(InputError, match="'w' is no state of the plant"):
        with_friction(MODEL.horizontal, {"w": 5.0}, 7.3)
    with pytest.raises(ValueError, match=r"mass 0\.0 kg"):
        with_friction(MODEL.horizontal, {"u": 5.0}, 0.0)


def test_speed_sensor() -> None:
    plant = named(first_order(0.0, 1.0, -1.0), ("U_mot",), ("Omega",), "Omega")
    plant = replace(plant, states=("Omega",))
    seen = with_speed_sensor(plant, 0.005)
    assert seen.states == seen.outputs == ("Omega", MEASURED_SPEED)
    np.testing.assert_allclose(seen.A, [[plant.A[0, 0], 0.0], [200.0, -200.0]])
    np.testing.assert_allclose(seen.B, [[plant.B[0, 0]], [0.0]])
    np.testing.assert_allclose(seen.C, [[plant.C[0, 0], 0.0], [0.0, 1.0]])
    with pytest.raises(ValueError, match=r"lag 0\.0 s"):
        with_speed_sensor(plant, 0.0)
    with pytest.raises(InputError, match="'Omega' is no state of the plant"):
        with_speed_sensor(MODEL.horizontal, 0.005)


def test_bad_arguments_are_refused() -> None:
    with pytest.raises(ValueError, match="pulse_ns 15; allowed: a multiple of 10"):
        LoopTiming(control_ns=10, pulse_ns=15)
    with pytest.raises(ValueError, match="latch_ns 20; allowed"):
        LoopTiming(control_ns=10, pulse_ns=20, latch_ns=20)
    with pytest.raises(ValueError, match="dead_ns -1; allowed"):
        LoopTiming(dead_ns=-1)
    plant = named(first_order(0.0, 1.0, 0.0), ("u",), ("z",), "x")
    with pytest.raises(InputError, match="'y' is no output of the plant"):
        SampledLoop(plant, gain_block(1.0))
    with pytest.raises(InputError, match="'u' is no input of the plant"):
        SampledLoop(named(first_order(0.0, 1.0, 0.0), ("w",), ("y",), "x"), gain_block(1.0))
