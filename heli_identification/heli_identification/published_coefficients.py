"""Coefficients that the source prints (Tables 2.2 and 2.6, app. C), for the side of ours.

The scan of Table 2.6 is damaged: X_u of the full structure is uncertain, the rows of M_u, M_v, L_u and L_v
are scrambled and left out. Its linearised inputs are per degree and are turned into 1/rad here; of its
identified inputs it does not print the unit. Table 2.2 prints no units at all.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import degrees

_IDENTIFIED = {
    "full": {
        "X_u": -5.3,
        "Y_v": -1.1767,
        "M_q": -21.81,
        "L_p": -6.489,
        "M_1": 81.441,
        "M_2": -34.029,
        "L_1": -7.6115,
        "L_2": 35.292,
    },
    "servo_rotor": {
        "X_u": -1.0724,
        "Y_v": -1.1887,
        "M_q": -3.7446,
        "L_p": -34.615,
        "M_a": -1554.7,
        "M_b": 2067.4,
        "L_a": 158.55,
        "L_b": 1587.2,
        "M_1": 41.324,
        "M_2": -39.869,
        "L_1": 32.265,
        "L_2": 82.95,
        "k": 11.2,
    },
    "drive": {"T_a": 0.0134, "k_a": 40.131, "k_Omega": 127.76, "D_Omega": -0.003},
}
_LINEARISED = {
    "X_u": -0.012,
    "Y_v": -0.067,
    "M_q": -13.81,
    "L_p": -34.702,
    "M_a": 242.54,
    "M_b": 64.313,
    "L_a": -161.52,
    "L_b": 609.11,
    "M_1": degrees(2.65),
    "M_2": degrees(0.7046),
    "L_1": degrees(-1.7697),
    "L_2": degrees(6.673),
    "k": 11.2,
}

APPENDIX_MOTOR_TIME = 0.043
"""T_a as app. C prints it [s]; it conflicts with Table 2.2."""

NOTES = {
    "horizontal": "Source: Table 2.6. X_u of the full structure is uncertain in the scan; the rows of M_u, "
    "M_v, L_u and L_v are scrambled and left out. The linearised inputs are turned from 1/deg into 1/rad; "
    "the unit of the identified inputs is not printed.",
    "vertical": "Source: Table 2.7 is scrambled in the scan.",
    "drive": "Source: Table 2.2, motor without rotor, units not printed; k_L stands beside D_Omega. Appendix "
    "C prints T_a = 0.043 s instead of 0.0134 s. The source calls the drive's corner 73 Hz; 1 / 0.0134 s is "
    "75 rad/s, 1 / 0.043 s is 23 rad/s, so its text goes with Table 2.2, if Hz stands for rad/s.",
}


def published(structure: str) -> dict[str, Mapping[str, float]]:
    """Columns of the source by title, coefficient by coefficient, for a structure's name."""
    if structure.startswith("drive"):
        return {"Table 2.2": _IDENTIFIED["drive"]}
    if structure in ("full", "servo_rotor"):
        return {
            "full information": _IDENTIFIED["full"],
            "with servo rotor": _IDENTIFIED["servo_rotor"],
            "linearised": _LINEARISED,
        }
    return {}
