"""The motor's PI controller, taken from an H-infinity design of the drive (source sec. 3.1.1, spec 3.1).

GS/T with an integrating weight on the rotor speed gives K(s), which below the cross-over is a PI controller,
K_p (1 + 1 / (T_i s)) of eq. 3.2, and falls above. K_p and T_i are those with the smallest relative error of
the frequency response below the cross-over.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from heli_common.model_file import ModelFile
from heli_control.flight_design import AxisDesign, axis_design, provenance_of, software
from heli_control.flight_plants import DRIVE
from heli_control.loop_analysis import crossovers
from heli_control.motor_control import MotorParameters
from heli_control.motor_controller_file import MotorControllerFile
from heli_control.realisation import Array, Complex, Realisation, response, unnamed
from heli_control.weights_file import WeightsFile

_SLOWEST = 0.05
"""Lower end of the frequencies that PI and H-infinity are compared at [rad/s]."""


@dataclass(frozen=True, eq=False)
class MotorDesign:
    """The motor's controller and how it came about.

    Attributes:
        axis: the H-infinity design.
        crossover: of its loop [rad/s].
        bandwidth: of the closed loop with the PI controller, where |T| falls to -3 dB [rad/s].
        apart: largest relative difference of PI and H-infinity below the cross-over.
        file: what the node reads.
    """

    axis: AxisDesign
    crossover: float
    bandwidth: float
    apart: float
    file: MotorControllerFile


def design_motor_controller(
    model: ModelFile, weights: WeightsFile, parameters: MotorParameters | None = None
) -> MotorDesign:
    """PI gains from the H-infinity controller of the drive.

    Args:
        model: with the drive or with all states.
        weights: of kind `motor`.
        parameters: drive data and anti-windup to keep; the shipped ones without.

    Raises:
        InputError: the model has no drive, or no controller can be certified; says why.
    """
    design = axis_design(model, weights, DRIVE)
    made = design.synthesis
    omega: Array = np.asarray(np.geomspace(1e-2, 1e3, 2000), dtype=np.float64)
    controller = unnamed(made.controller)
    feedback = Realisation(controller.A, -controller.B[:, :1], controller.C, -controller.D[:, :1])
    exact = response(feedback, omega)[:, 0, 0]
    plant = response(unnamed(made.plant.si), omega)[:, 0, 0]
    crossover = crossovers(exact * plant, omega)[-1]
    below = (omega >= _SLOWEST) & (omega <= crossover)
    gain, integral_time = proportional_integral(omega[below], exact[below])
    law = gain * (1.0 + 1.0 / (1j * omega * integral_time))
    closed = np.abs(law * plant / (1.0 + law * plant))
    apart = float((np.abs(law - exact) / np.abs(exact))[below].max())
    bandwidth = float(omega[np.argmax((closed < np.sqrt(0.5)) & (omega > _SLOWEST))])
    provenance = {
        "method": "PI from H-infinity GS/T of the drive, certified",
        "weights": weights.mapping()[DRIVE],
        DRIVE: provenance_of(design),
        "crossover_rad_s": crossover,
        "bandwidth_rad_s": bandwidth,
        "apart_below_crossover": apart,
        "software": software(),
    }
    kept = replace(parameters or MotorParameters(), gain=gain, integral_time=integral_time)
    file = MotorControllerFile("motor", "pi", kept, model.name, model.plant_hash, provenance)
    return MotorDesign(design, crossover, bandwidth, apart, file)


def proportional_integral(omega: Array, wanted: Complex) -> tuple[float, float]:
    """K_p and T_i of the PI controller nearest to a frequency response, relative least squares.

    Args:
        omega: shape (k,) [rad/s].
        wanted: K(j omega), shape (k,).

    Returns:
        K_p in the response's unit, T_i [s].
    """
    # K_p (1 + 1/(j w T_i)): real part K_p, imaginary part -(K_p / T_i) / w
    weight = 1.0 / np.abs(wanted)
    real = np.column_stack((weight, np.zeros_like(omega)))
    imaginary = np.column_stack((np.zeros_like(omega), -weight / omega))
    right = np.concatenate((wanted.real * weight, wanted.imag * weight))
    (gain, rate), *_ = np.linalg.lstsq(np.vstack((real, imaginary)), right, rcond=None)
    return float(gain), float(gain / rate)
