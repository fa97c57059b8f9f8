"""Margins: by hand, against the library, against perturbed loops, sampled and continuous alike."""

import math

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_control.discretisation import discrete, sampled_response
from heli_control.margins import (
    disk_margin,
    disk_sizes,
    eigenvalue_loci,
    loop_margins,
    loops,
    scalar_margins,
)
from heli_control.realisation import Realisation, diagonal, first_order, realisation, response, series

OMEGA = np.geomspace(1e-3, 1e3, 3000)
THREE_LAGS = series(
    first_order(0.0, 4.0, 1.0), series(first_order(0.0, 1.0, 1.0), first_order(0.0, 1.0, 1.0))
)


def scalar(system: Realisation) -> np.ndarray:
    return response(system, OMEGA)[:, 0, 0]


def closed(system: Realisation, factor: complex | np.ndarray) -> float:
    """Largest real part of a pole of the loop closed through a factor per channel."""
    gain = np.diag(np.broadcast_to(factor, (len(system.D),)))
    a = system.A.astype(complex) - system.B @ gain @ np.linalg.solve(
        np.eye(len(gain)) + system.D @ gain, system.C
    )
    return float(np.linalg.eigvals(a).real.max())


def test_three_lags_by_hand() -> None:
    # 4 / (s + 1)^3 turns by 180 deg at sqrt(3) with the gain 1/2
    margins = scalar_margins(scalar(THREE_LAGS), OMEGA)
    assert margins.gain_up_db == pytest.approx(20.0 * math.log10(2.0), abs=1e-3)
    assert math.isinf(margins.gain_down_db)
    crossover = math.sqrt(4.0 ** (2.0 / 3.0) - 1.0)
    assert margins.crossovers == pytest.approx([crossover], rel=1e-5)
    phase = math.pi - 3.0 * math.atan(crossover)
    assert margins.phase_deg == pytest.approx(math.degrees(phase), abs=1e-3)
    assert margins.delay_ms == pytest.approx(1e3 * phase / crossover, rel=1e-4)


def test_an_unstable_plant_has_a_gain_it_needs() -> None:
    # 3 / (s - 1): stable for gains above 1/3, and of any size
    margins = scalar_margins(scalar(first_order(0.0, 3.0, -1.0)), OMEGA)
    assert margins.gain_down_db == pytest.approx(20.0 * math.log10(3.0), abs=1e-3)
    assert math.isinf(margins.gain_up_db)


def test_sampled_integrator_has_its_margin_at_nyquist() -> None:
    # g T / (z - 1) is stable closed for g T < 2
    period = 0.1
    omega = np.append(np.geomspace(1e-3, 31.0, 2000), math.pi / period)
    loop = sampled_response(discrete(first_order(0.0, 4.0, 0.0), "hold", period), omega, period)
    margins = scalar_margins(loop[:, 0, 0], omega)
    assert margins.gain_up_db == pytest.approx(20.0 * math.log10(2.0 / (4.0 * period)), abs=1e-6)


@settings(deadline=None, max_examples=25, derandomize=True)
@given(st.integers(0, 10**6))
def test_scalar_margins_are_those_of_the_library(seed: int) -> None:
    rng = np.random.default_rng(seed)
    system = series(
        first_order(0.0, rng.uniform(1.0, 6.0), rng.uniform(0.1, 2.0)),
        series(first_order(0.0, 3.0, rng.uniform(1.0, 4.0)), first_order(0.0, 2.0, rng.uniform(1.0, 9.0))),
    )
    margins = scalar_margins(scalar(system), OMEGA)
    gm, pm, _, _, wpc, _ = control.stability_margins(control.ss(*system))
    if gm > 1.0:  # else the closed loop is unstable
        assert 10.0 ** (margins.gain_up_db / 20.0) == pytest.approx(gm, rel=1e-3)
        if np.isfinite(wpc):
            assert margins.phase_deg == pytest.approx(abs(pm), abs=0.05)
            assert margins.crossovers == pytest.approx([wpc], rel=1e-3)


def random_loop(rng: np.random.Generator, m: int, n: int = 4) -> Realisation:
    """A loop whose closed loop is stable, itself perhaps not."""
    while True:
        a = rng.standard_normal((n, n)) - 0.5 * np.eye(n)
        loop = realisation(
            a, 2.0 * rng.standard_normal((n, m)), rng.standard_normal((m, n)), np.zeros((m, m))
        )
        if closed(loop, 1.0) < -0.05:
            return loop


@settings(deadline=None, max_examples=15, derandomize=True)
@given(st.integers(0, 10**6))
def test_margins_are_where_the_closed_loop_becomes_unstable(seed: int) -> None:
    loop = random_loop(np.random.default_rng(seed), 2)
    margins = loop_margins(response(loop, OMEGA), OMEGA, ("one", "two"))
    for channel, one in ((None, margins.uniform), (0, margins.channels["one"]), (1, margins.channels["two"])):

        def factor(value: complex, channel: int | None = channel) -> np.ndarray:
            return np.array([value if channel in (None, index) else 1.0 for index in range(2)])

        for level, sign in ((one.gain_up_db, 1.0), (one.gain_down_db, -1.0)):
            if level < 50.0:
                assert closed(loop, factor(10.0 ** (sign * 0.98 * level / 20.0))) < 0.0
                assert closed(loop, factor(10.0 ** (sign * (1.02 * level + 0.02) / 20.0))) > 0.0
        if one.phase_deg < 180.0:
            turns = [np.exp(sign * 1j * math.radians(one.phase_deg)) for sign in (1.0, -1.0)]
            assert min(abs(closed(loop, factor(turn))) for turn in turns) < 0.02 * np.abs(loop.A).max()
            for share in (0.0, 0.5, 0.98):
                assert closed(loop, factor(turns[0] ** share)) < 0.0
                assert closed(loop, factor(turns[1] ** share)) < 0.0


@settings(deadline=None, max_examples=15, derandomize=True)
@given(st.integers(0, 10**6), st.integers(1, 3))
def test_disk_margin_is_that_of_the_library_and_never_larger(seed: int, m: int) -> None:
    loop = random_loop(np.random.default_rng(seed), m)
    omega = np.geomspace(0.01, 100.0, 60)
    ours = disk_sizes(response(loop, omega))
    library = control.disk_margins(control.ss(*loop), omega, returnall=True)
    assert (ours <= library[0] * 1.002).all()
    np.testing.assert_allclose(ours, library[0], rtol=2e-3 if m < 3 else 3e-2)
    if m == 3:
        return
    margin = disk_margin(response(loop, omega), omega)
    worst = control.disk_margins(control.ss(*loop), omega)
    assert margin.gain_db == pytest.approx(worst[1], rel=5e-3)
    assert margin.phase_deg == pytest.approx(worst[2], rel=5e-3)


def test_what_a_disk_margin_guarantees_is_borne() -> None:
    rng = np.random.default_rng(3)
    for _ in range(5):
        loop = random_loop(rng, 2)
        margin = disk_margin(response(loop, OMEGA), OMEGA)
        gain, phase = 10.0 ** (0.99 * min(margin.gain_db, 60.0) / 20.0), math.radians(0.99 * margin.phase_deg)
        for one in (gain, 1.0 / gain, np.exp(1j * phase), np.exp(-1j * phase)):
            for two in (gain, 1.0 / gain, np.exp(1j * phase), np.exp(-1j * phase)):
                assert closed(loop, np.array([one, two])) < 0.0


def test_independent_channels_have_scalar_disks() -> None:
    lag = first_order(0.0, 5.0, 1.0)
    both = response(diagonal(lag, THREE_LAGS), OMEGA)
    alone = [disk_margin(response(system, OMEGA), OMEGA).alpha for system in (lag, THREE_LAGS)]
    assert disk_margin(both, OMEGA).alpha == pytest.approx(min(alone), rel=1e-6)
    # a coupling one way changes nothing, though it makes the singular value larger
    skewed = both.copy()
    skewed[:, 0, 1] = 30.0 * both[:, 0, 0]
    assert disk_margin(skewed, OMEGA).alpha == pytest.approx(min(alone), rel=1e-2)
    margins = loop_margins(skewed, OMEGA, ("lag", "three"))
    assert margins.channels["three"].gain_up_db == pytest.approx(6.0206, abs=1e-3)
    assert not margins.within_limits


def test_peaks_and_limits() -> None:
    margins = loop_margins(response(first_order(0.0, 5.0, 0.0), OMEGA), OMEGA, ("one",))
    assert margins.within_limits
    assert margins.peak_S_db == pytest.approx(0.0, abs=1e-3)
    assert margins.frequency_S == OMEGA[-1]
    assert margins.frequency_T == OMEGA[0]
    assert margins.channels["one"].crossovers == pytest.approx([5.0], rel=1e-4)


def test_loci_are_continuous_where_eigenvalues_cross() -> None:
    loop = np.array([np.diag([1.0 + 0.1 * k, 2.0 - 0.1 * k]) for k in range(11)], dtype=complex)
    loci = eigenvalue_loci(loop)
    assert np.abs(np.diff(loci, axis=0)).max() == pytest.approx(0.1)


def test_bad_shapes_are_refused() -> None:
    with pytest.raises(ValueError, match="loop of shape"):
        loop_margins(np.zeros((3, 2, 2), dtype=complex), OMEGA, ("a", "b"))


def test_loops_at_input_and_output_have_the_same_uniform_margins() -> None:
    rng = np.random.default_rng(8)
    plant = realisation(
        rng.standard_normal((4, 4)) - 3.0 * np.eye(4),
        rng.standard_normal((4, 1)),
        np.eye(4)[:3],
        np.zeros((3, 1)),
    )
    controller = -rng.uniform(0.5, 3.0, (1, 3)) * np.ones((300, 1, 1))
    omega = OMEGA[::10]
    at_input, at_output = loops(response(plant, omega), controller)
    one = loop_margins(at_input, omega, ("u",)).uniform
    three = loop_margins(at_output, omega, ("a", "b", "c")).uniform
    assert three.phase_deg == pytest.approx(one.phase_deg, abs=0.1)
    assert three.crossovers == pytest.approx(one.crossovers, rel=1e-3)
    # a channel that is not fed back at all has no margin to lose
    nothing = scalar_margins(np.zeros(len(OMEGA), dtype=complex), OMEGA)
    assert math.isinf(nothing.gain_up_db)
    assert nothing.crossovers == ()


def test_a_scalar_disk_survives_rounding() -> None:
    # spectral radius and norm of a scalar may differ in the last bit, either way
    omega = np.geomspace(0.02, 500.0, 1500)
    for level in np.linspace(0.7, 40.0, 60):
        loop = response(first_order(0.0, float(level), 0.1), omega)
        exact = 1.0 / np.abs(1.0 / (1.0 + loop[:, 0, 0]) - 0.5)
        assert disk_margin(loop, omega).alpha == pytest.approx(exact.min(), rel=1e-8)
