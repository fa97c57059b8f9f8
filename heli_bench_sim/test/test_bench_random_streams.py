"""One stream of random numbers per component and seed."""

import math

import numpy as np
import pytest

from heli_bench_sim.random_streams import generator

NAMES = ("imu", "imu_bias", "wind", "room_air", "excitation")


def test_stream_is_known_on_every_machine() -> None:
    """Written down once: these are raw words of PCG64, which numpy never changes."""
    assert generator(7, "imu").bit_generator.random_raw(2).tolist() == [
        14_030_215_686_508_602_307,
        18_159_608_323_606_293_989,
    ]


def test_same_seed_same_numbers_other_seed_others() -> None:
    first = generator(3, "wind").standard_normal(8)
    assert generator(3, "wind").standard_normal(8).tobytes() == first.tobytes()
    for other in (generator(4, "wind"), generator(3, "wine"), generator(3 + 2**32, "wind")):
        assert not np.isin(other.standard_normal(8), first).any()


def test_components_and_seeds_are_uncorrelated() -> None:
    """The correlation of n independent pairs has a standard deviation of 1 / sqrt(n)."""
    n = 100_000
    rows = [generator(1, name).standard_normal(n) for name in NAMES]
    rows += [generator(seed, NAMES[0]).standard_normal(n) for seed in (2, 3)]
    cross = np.corrcoef(rows)[np.triu_indices(len(rows), 1)]
    assert np.abs(cross).max() < 5.0 / math.sqrt(n)


def test_a_stream_does_not_feel_what_others_draw() -> None:
    one, other = generator(5, "imu"), generator(5, "wind")
    alone = generator(5, "imu").standard_normal(100)
    other.standard_normal(1000)
    first = one.standard_normal(50)
    other.standard_normal(1)
    assert np.concatenate((first, one.standard_normal(50))).tobytes() == alone.tobytes()


def test_negative_seed_is_refused() -> None:
    with pytest.raises(ValueError, match=r"seed -1 is negative \(allowed"):
        generator(-1, "imu")
