"""Data of known models for the tests."""

import numpy as np

from heli_identification.helicopter_structures import SERVO_ROTOR
from heli_identification.linear_twin import Disturbance, Twin, lq_feedback
from heli_identification.records import Record
from heli_identification.structures import Structure

PERIOD = 0.01
TRUTH = SERVO_ROTOR.with_values({"X_u": -1.07, "Y_v": -1.19})


def binary(rng: np.random.Generator, count: int, amplitude: float = 0.015, hold: int = 8) -> np.ndarray:
    return amplitude * np.repeat(rng.choice([-1.0, 1.0], size=(count // hold + 1, 2)), hold, axis=0)[:count]


def servo_rotor_twin(noise: float = 1.0, structure: Structure = TRUTH) -> Twin:
    process = noise * np.array([0.0, 0.0, 0.003, 0.003, 0.01, 0.01, 0.0, 0.0])
    measurement = noise * np.array([0.001, 0.001, 0.005, 0.005, 0.01, 0.01])
    return Twin(structure, lq_feedback(structure, PERIOD), Disturbance(process, measurement), PERIOD, delay=1)


def flown(seed: int, seconds: float, noise: float = 1.0) -> Record:
    rng = np.random.default_rng(seed)
    return servo_rotor_twin(noise).fly(binary(rng, round(seconds / PERIOD)), rng, f"seed {seed}")


def perturbed(structure: Structure, seed: int, share: float = 0.2) -> Structure:
    rng, index = np.random.default_rng([seed, 1]), structure.index(structure.free_names)
    moved = structure.values[index] * (1.0 + share * rng.standard_normal(len(index)))
    return structure.with_values(dict(zip(structure.free_names, moved.tolist(), strict=True)))


def true_values(names: tuple[str, ...], structure: Structure = TRUTH) -> np.ndarray:
    return structure.values[structure.index(names)]
