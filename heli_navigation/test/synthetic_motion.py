"""A made-up flight for tests: smooth motion, its IMU and its encoders, without the simulated bench."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heli_common.rig_geometry import RADIAN_PER_COUNT, RigGeometry
from heli_navigation.arm_kinematics import arms_from_position
from heli_navigation.filter_parameters import FilterParameters
from heli_navigation.inertial_navigation import InertialNavigation

Array = NDArray[np.float64]

GEOMETRY, PARAMETERS = RigGeometry(), FilterParameters()
PERIOD = 2.5e-3
LEVER = np.array([PARAMETERS.imu_x, PARAMETERS.imu_y, PARAMETERS.imu_z])
INDEXED = (1.0,) * 6


def matrices(attitude: Array) -> Array:
    """(n, 3, 3) C_nb of (n, 3) yaw, pitch, roll."""
    psi, theta, phi = attitude.T
    spsi, cpsi, sth, cth, sphi, cphi = (
        function(angle) for angle in (psi, theta, phi) for function in (np.sin, np.cos)
    )
    rows = [
        [cpsi * cth, cpsi * sth * sphi - spsi * cphi, cpsi * sth * cphi + spsi * sphi],
        [spsi * cth, spsi * sth * sphi + cpsi * cphi, spsi * sth * cphi - cpsi * sphi],
        [-sth, cth * sphi, cth * cphi],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


@dataclass
class Flight:
    """Truth and sensors, sample by sample; vectors in rows, angles in rad."""

    position: Array
    attitude: Array
    velocity: Array
    """body FRD"""
    rates: Array
    """body FRD"""
    angles: Array
    """of the six encoders as their counts say"""
    gyro: Array
    force: Array
    gyro_bias: Array
    force_bias: Array

    def __len__(self) -> int:
        return len(self.position)


def fly(seed: int, seconds: float, still: float = 0.0, size: float = 1.0, noise: float = 1.0) -> Flight:
    """Swinging about a hover; with `still`, from standing on the stop that long.

    Args:
        seed: of phases, biases and noise.
        seconds: length.
        still: time at rest on the stop at the beginning [s].
        size: factor on the motion.
        noise: factor on the IMU's noise.
    """
    generator = np.random.default_rng(seed)
    count = round(seconds / PERIOD)
    frequency = np.array([[0.4, 0.7], [0.5, 0.8], [0.3, 0.6], [0.35, 0.9], [0.8, 1.3], [0.7, 1.2]])
    phase = generator.uniform(0.0, 2.0 * math.pi, (6, 2))
    reach = size * np.array([0.05, 0.05, 0.04, 0.10, 0.03, 0.03])

    def pose(time: Array) -> Array:
        turn = 2.0 * math.pi * frequency[:, :, None] * time + phase[:, :, None]
        swing = reach[:, None] * np.sin(turn).sum(axis=1)
        # from the stop: a start without a jump in position, speed or acceleration
        share = np.clip((time - still) / 2.0, 0.0, 1.0) if still > 0.0 else np.ones_like(time)
        grown = share**3 * (share * (6.0 * share - 15.0) + 10.0)
        low = np.array([0.0, 0.0, GEOMETRY.rest_depth, 0.0, 0.0, 0.0])[:, None]
        return np.asarray(((1.0 - grown) * low + grown * swing).T)

    def imu_place(time: Array) -> Array:
        now = pose(time)
        return now[:, :3] + np.einsum("nij,j->ni", matrices(now[:, 3:]), LEVER)

    time, step = PERIOD * np.arange(count), 1e-4
    now = pose(time)
    slope = (pose(time + step) - pose(time - step)) / (2.0 * step)
    body = matrices(now[:, 3:])
    acceleration = (imu_place(time + step) - 2.0 * imu_place(time) + imu_place(time - step)) / step**2
    theta, phi = now[:, 4], now[:, 5]
    d_psi, d_theta, d_phi = slope[:, 3:].T
    rates = np.stack(
        [
            d_phi - d_psi * np.sin(theta),
            d_theta * np.cos(phi) + d_psi * np.cos(theta) * np.sin(phi),
            -d_theta * np.sin(phi) + d_psi * np.cos(theta) * np.cos(phi),
        ],
        axis=1,
    )
    gravity = np.array([0.0, 0.0, PARAMETERS.gravity])
    force = np.einsum("nji,nj->ni", body, acceleration - gravity)
    gyro_bias = generator.normal(0.0, math.radians(0.5), 3)
    force_bias = generator.normal(0.0, 0.05, 3)
    samples = noise / math.sqrt(PERIOD)
    walk = np.cumsum(generator.normal(0.0, PARAMETERS.gyro_walk * math.sqrt(PERIOD), (count, 3)), axis=0)
    biases = gyro_bias + noise * walk
    arms = np.array([arms_from_position((x, y, z), GEOMETRY) for x, y, z in now[:, :3].tolist()])
    angles = np.hstack([arms, now[:, 3:]])
    return Flight(
        position=now[:, :3],
        attitude=now[:, 3:],
        velocity=np.einsum("nji,nj->ni", body, slope[:, :3]),
        rates=rates,
        angles=RADIAN_PER_COUNT * np.floor(angles / RADIAN_PER_COUNT + 0.5),
        gyro=rates + biases + samples * generator.normal(0.0, PARAMETERS.gyro_noise, (count, 3)),
        force=force
        + force_bias
        + samples * generator.normal(0.0, PARAMETERS.accelerometer_noise, (count, 3)),
        gyro_bias=biases,
        force_bias=force_bias,
    )


def feed(navigation: InertialNavigation, flight: Flight, samples: range, imu_valid: bool = True) -> None:
    """Let the navigation see some samples of a flight."""
    for k in samples:
        angles = flight.angles[k].tolist()
        gyro, force = flight.gyro[k].tolist(), flight.force[k].tolist()
        navigation.step(angles[:3], angles[3:], INDEXED, gyro, force, imu_valid)


def nees(error: Array, covariance: Array) -> float:
    """Normalised estimation error squared, per degree of freedom."""
    return float(error @ np.linalg.solve(covariance, error)) / len(error)
