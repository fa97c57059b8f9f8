"""The structures of the source's section 2.5.2, with the project's signs (spec 1.1, 1.3).

    horizontal, full information (eq. 2.82)      u' = -g theta + X_u u + X_1 B_1s        theta' = q
                                                 v' =  g phi   + Y_v v + Y_2 A_1s        phi'   = p
                                                 q' = M_u u + M_v v + M_q q + M_1 B_1s + M_2 A_1s
                                                 p' = L_u u + L_v v + L_p p + L_1 B_1s + L_2 A_1s
    with servo rotor (eq. 2.83)                  q' += M_a a_1p + M_b b_1p,  p' += L_a a_1p + L_b b_1p
                                                 a_1p' = k (-a_1p + k_s2p B_1s + p / Omega_0) - q
                                                 b_1p' = k (-b_1p + k_s2p A_1s - q / Omega_0) - p
    vertical, full information (eq. 2.85)        w' = Z_w w + Z_0 theta_0
                                                 r' = N_w w + N_r r + N_t theta_t
    with inflow (eq. 2.84)                       w' += Z_Vi V_i,  r' += N_Vi V_i + N_Vt V_t + N_0 theta_0
                                                 V_i' = k_w w + k_Vi V_i + k_u0 theta_0
                                                 V_t' = k_r r + k_Vt V_t + k_ut theta_t
    drive (eq. 2.48, 2.49)                       M_A' = (-M_A - k_Omega Omega + k_U U_mot) / T_a
                                                 Omega' = k_a M_A + D_Omega Omega
    drive with the torque measured, too          the same with k_a and D_Omega free

Prior values: the source's linearised model where the scan is readable, else the rebuilt one (spec 1.5).
"""

from __future__ import annotations

from dataclasses import replace

from heli_common.errors import InputError
from heli_identification.structures import Parameter, Structure, Term

GRAVITY = 9.81
"""[m/s^2]"""
ROTOR_SPEED = 163.363
"""Omega_0 [rad/s]"""
SHAFT_REACTION = 0.1702
"""Yaw acceleration per acceleration of the rotor shaft: the drive's inertia over the body's about z (spec
1.5: the columns of the motor torque in the linear model, 17.61 over 103.46)."""
BAR_GAIN = 1.4199
"""k_s2p: the swash plate's gain on the servo rotor (spec 1.4). It sets the unit of a_1p and b_1p."""

SCALES = {
    "theta": 0.2,
    "phi": 0.2,
    "u": 0.2,
    "v": 0.2,
    "w": 0.2,
    "q": 1.0,
    "p": 1.0,
    "r": 1.0,
    "a_1p": 1.0,
    "b_1p": 1.0,
    "V_i": 1.0,
    "V_t": 1.0,
    "Omega": 5.0,
    "M_A": 1.0,
    "B_1s": 0.02,
    "A_1s": 0.02,
    "theta_0": 0.02,
    "theta_t": 0.25,
    "U_mot": 2.0,
}
"""Typical deviations, SI (source Table 2.4)."""


def _parameters(table: str, fixed: dict[str, str] | None = None) -> tuple[Parameter, ...]:
    """Parameters from lines `name value[~size] unit`; fixed ones with the reason."""
    reasons = fixed or {}
    found = []
    for line in table.strip().splitlines():
        name, value, unit = line.split(maxsplit=2)
        start, _, size = value.partition("~")
        scale = float(size) if size else abs(float(start)) or 1.0
        free, reason = name not in reasons, reasons.get(name, "")
        found.append(Parameter(name, float(start), scale, unit, free, reason))
    return tuple(found)


def _entries(table: str) -> tuple[Term, ...]:
    """Terms from lines `row: column parameter, ...`, each with factor 1."""
    found = []
    for line in table.strip().splitlines():
        row, _, rest = line.partition(":")
        for entry in rest.split(","):
            column, name = entry.split()
            found.append(Term(row.strip(), column, 1.0, ((name, 1),)))
    return tuple(found)


_KINEMATICS = (
    Term("theta", "q", 1.0),
    Term("phi", "p", 1.0),
    Term("u", "theta", -GRAVITY),
    Term("v", "phi", GRAVITY),
)
_BODY_TERMS = _KINEMATICS + _entries("""
    u: u X_u, B_1s X_1
    v: v Y_v, A_1s Y_2
    q: u M_u, v M_v, q M_q, B_1s M_1, A_1s M_2
    p: u L_u, v L_v, p L_p, B_1s L_1, A_1s L_2
""")
_SPEED_STAGE = ("X_u", "X_1", "Y_v", "Y_2")
_RATE_STAGE = ("M_q", "M_1", "M_2", "L_p", "L_1", "L_2")
_MOTION = ("theta", "phi", "u", "v", "q", "p")

FULL = Structure(
    name="full",
    states=_MOTION,
    inputs=("B_1s", "A_1s"),
    outputs=_MOTION,
    parameters=_parameters("""
        X_u -0.012~1 1/s
        X_1 -3.13 m/(s^2 rad)
        Y_v -0.067~1 1/s
        Y_2 3.13 m/(s^2 rad)
        M_u 0.717~1 rad/(m s)
        M_v -0.19~1 rad/(m s)
        M_q -13.81 1/s
        M_1 151.83 1/s^2
        M_2 40.37 1/s^2
        L_u -0.478~2 rad/(m s)
        L_v -1.802~2 rad/(m s)
        L_p -34.702 1/s
        L_1 -101.4 1/s^2
        L_2 382.34 1/s^2
    """),
    terms=_BODY_TERMS,
    stages=(_RATE_STAGE, _SPEED_STAGE, ("M_u", "M_v", "L_u", "L_v")),
)

SERVO_ROTOR = Structure(
    name="servo_rotor",
    states=(*_MOTION, "a_1p", "b_1p"),
    inputs=FULL.inputs,
    outputs=_MOTION,
    parameters=(
        *FULL.parameters,
        *_parameters(
            """
            M_a 242.54 1/s^2
            M_b 64.313 1/s^2
            L_a -161.52 1/s^2
            L_b 609.11 1/s^2
            k 11.2 1/s
            """,
            {"k": "swash plate and servo rotor carry the same input; the source keeps 11.2 1/s"},
        ),
    ),
    terms=(
        *_BODY_TERMS,
        *_entries("""
            q: a_1p M_a, b_1p M_b
            p: a_1p L_a, b_1p L_b
        """),
        Term("a_1p", "a_1p", -1.0, (("k", 1),)),
        Term("a_1p", "B_1s", BAR_GAIN, (("k", 1),)),
        Term("a_1p", "p", 1.0 / ROTOR_SPEED, (("k", 1),)),
        Term("a_1p", "q", -1.0),
        Term("b_1p", "b_1p", -1.0, (("k", 1),)),
        Term("b_1p", "A_1s", BAR_GAIN, (("k", 1),)),
        Term("b_1p", "q", -1.0 / ROTOR_SPEED, (("k", 1),)),
        Term("b_1p", "p", -1.0),
    ),
    stages=(_RATE_STAGE, _SPEED_STAGE, ("M_u", "M_v", "L_u", "L_v"), ("M_a", "M_b", "L_a", "L_b")),
)

VERTICAL_FULL = Structure(
    name="vertical_full",
    states=("w", "r"),
    inputs=("theta_0", "theta_t"),
    outputs=("w", "r"),
    parameters=_parameters(
        """
        Z_w -0.71 1/s
        Z_0 -57.8 m/(s^2 rad)
        N_w -0.65 rad/(m s)
        N_r -0.89 1/s
        N_0 0.0 1/s^2
        N_t -75.6 1/s^2
        """,
        {"N_0": "the source drops the collective's torque on yaw (eq. 2.85)"},
    ),
    terms=_entries("""
        w: w Z_w, theta_0 Z_0
        r: w N_w, r N_r, theta_0 N_0, theta_t N_t
    """),
    stages=(("Z_w", "Z_0"), ("N_r", "N_t", "N_w")),
)

_NORMALISED = "the induced velocity is not measured: its unit is free, this coefficient sets it"
_LAG = "only sums and products with the other coefficients of the path are seen; kept at its time constant"

VERTICAL = Structure(
    name="vertical",
    states=("w", "r", "V_i", "V_t"),
    inputs=VERTICAL_FULL.inputs,
    outputs=VERTICAL_FULL.outputs,
    parameters=_parameters(
        """
        Z_w -1.047 1/s
        Z_Vi 1.077 1/s
        Z_0 -84.6 m/(s^2 rad)
        N_w -0.596 rad/(m s)
        N_r -1.913 1/s
        N_Vi -0.183 rad/(m s)
        N_Vt 2.645 rad/(m s)
        N_0 100.4 1/s^2
        N_t -161.8 1/s^2
        k_w 3.019 1/s
        k_Vi -9.770 1/s
        k_u0 243.9 m/(s^2 rad)
        k_r 8.237 m/(s rad)
        k_Vt -21.39 1/s
        k_ut 696.4 m/(s^2 rad)
        """,
        {"k_u0": _NORMALISED, "k_ut": _NORMALISED, "k_Vi": _LAG, "k_Vt": _LAG},
    ),
    terms=_entries("""
        w: w Z_w, V_i Z_Vi, theta_0 Z_0
        r: w N_w, r N_r, V_i N_Vi, V_t N_Vt, theta_0 N_0, theta_t N_t
        V_i: w k_w, V_i k_Vi, theta_0 k_u0
        V_t: r k_r, V_t k_Vt, theta_t k_ut
    """),
    stages=(("Z_w", "Z_0", "N_r", "N_t"), ("N_w", "N_0"), ("Z_Vi", "N_Vi", "N_Vt"), ("k_w", "k_r")),
)

DRIVE = Structure(
    name="drive",
    states=("Omega", "M_A"),
    inputs=("U_mot",),
    outputs=("Omega",),
    parameters=_parameters(
        """
        T_a 0.0134 s
        k_U 1.285 Nm/V
        k_Omega 0.03854 Nms/rad
        k_a 103.46 1/(kgm^2)
        D_Omega 0.0 1/s
        """,
        {
            "k_a": "the torque is not measured: only its products with k_U and k_Omega are seen",
            "D_Omega": "the load's slope; zero without rotor load, else it hides in k_Omega",
        },
    ),
    terms=(
        Term("Omega", "M_A", 1.0, (("k_a", 1),)),
        Term("Omega", "Omega", 1.0, (("D_Omega", 1),)),
        Term("M_A", "M_A", -1.0, (("T_a", -1),)),
        Term("M_A", "Omega", -1.0, (("k_Omega", 1), ("T_a", -1))),
        Term("M_A", "U_mot", 1.0, (("k_U", 1), ("T_a", -1))),
    ),
    stages=(("k_U", "k_Omega"), ("T_a",)),
)

DRIVE_TORQUE = replace(
    DRIVE.with_free(DRIVE.names),
    name="drive_torque",
    outputs=("Omega", "M_A"),
    stages=(("k_U", "k_Omega", "k_a"), ("T_a", "D_Omega")),
)

STRUCTURES = {each.name: each for each in (FULL, SERVO_ROTOR, VERTICAL, VERTICAL_FULL, DRIVE, DRIVE_TORQUE)}


def structure_of(name: str) -> Structure:
    """A structure of the source by name.

    Raises:
        InputError: no such structure.
    """
    if name not in STRUCTURES:
        raise InputError(f"no structure {name!r}", allowed=", ".join(STRUCTURES), key="structure")
    return STRUCTURES[name]
