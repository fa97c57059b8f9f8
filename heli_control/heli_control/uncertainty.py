"""The source's robustness tests: how large an unknown perturbation a closed loop bears (source sec. 3.3.2).

If the perturbation Delta, stable and unknown, sees the operator T of the closed loop, the loop stays stable
for every |Delta| < 1 / |T| (small gain theorem), and for none larger is that sure. With u = K y:

    additive            G + Delta                     K S_e
    additive, feedback  G (I - Delta G)^-1            S_e G = G S_u
    multiplicative      (I + Delta) G, G (I + Delta)  T_e, T_u
    divisive            (I - Delta)^-1 G, G (I - Delta)^-1   S_e, S_u
    coprime factors     (M + D_M)^-1 (N + D_N)        [K; I] S_e M^-1

Sizes are in the units of plant and controller: scale both before if channels differ.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from heli_control.generalized_plant import GeneralizedPlant, lower_lft
from heli_control.hinf_norm import hinf_norm
from heli_control.loop_shaping import coprime_factors
from heli_control.realisation import Array, Realisation, response

ADDITIVE, FEEDBACK, COPRIME = "K S_e", "S_e G", "[K; I] S_e M^-1"
OPERATORS = {
    ADDITIVE: "additive",
    FEEDBACK: "additive in feedback",
    "T_e": "multiplicative at the output",
    "T_u": "multiplicative at the input",
    "S_e": "divisive at the output",
    "S_u": "divisive at the input",
    COPRIME: "coprime factors",
}
"""Operators, and the perturbation each of them is seen by."""


@dataclass(frozen=True)
class RobustnessTest:
    """One operator of the closed loop.

    Attributes:
        operator: its name, a key of `OPERATORS`.
        perturbation: what it is seen by.
        norm: H-infinity norm, upper bound; infinite for an unstable loop.
        tolerated: largest |Delta| for which the loop is surely stable.
        frequency: where the norm is reached [rad/s].
    """

    operator: str
    perturbation: str
    norm: float
    tolerated: float
    frequency: float


def closed_operators(plant: Realisation, controller: Realisation) -> dict[str, Realisation]:
    """Every operator of `OPERATORS` as a system.

    Args:
        plant: G, m inputs and p outputs.
        controller: u = K y, the minus sign of the feedback included.

    Raises:
        ValueError: sizes that do not fit, or a loop that is not well posed.
        SynthesisRefused: a mode of the plant that input or output does not reach.
    """
    a, b, c, d = plant
    p, m = d.shape
    # w: at the plant's input, at its output; z: u of the controller, input and output of the plant
    whole = GeneralizedPlant(
        A=a, B1=np.hstack((b, np.zeros((len(a), p)))), B2=b,
        C1=np.vstack((np.zeros((2 * m, len(a))), c)), C2=c,
        D11=np.block(
            [
                [np.zeros((m, m + p))],
                [np.eye(m), np.zeros((m, p))],
                [d, np.eye(p)],
            ]
        ),
        D12=np.vstack((np.eye(m), np.eye(m), d)), D21=np.hstack((d, np.eye(p))), D22=d,
    )  # fmt: skip
    loop = lower_lft(whole, controller)
    control, into, out = range(m), range(m, 2 * m), range(2 * m, 2 * m + p)
    at_input, at_output = range(m), range(m, m + p)
    made = {
        ADDITIVE: _between(loop, control, at_output),
        FEEDBACK: _between(loop, out, at_input),
        "S_e": _between(loop, out, at_output),
        "S_u": _between(loop, into, at_input),
        "T_u": _between(loop, control, at_input),
    }
    s_e = made["S_e"]
    made["T_e"] = s_e._replace(D=s_e.D - np.eye(p))
    made[COPRIME] = _coprime(plant, controller)
    return {name: made[name] for name in OPERATORS}


def robustness_tests(plant: Realisation, controller: Realisation) -> list[RobustnessTest]:
    """Norm, tolerated perturbation and worst frequency of every operator.

    Args:
        plant: G.
        controller: u = K y.

    Raises:
        ValueError, SynthesisRefused: see `closed_operators`.
    """
    results = []
    for name, system in closed_operators(plant, controller).items():
        norm = hinf_norm(system)
        tolerated = 1.0 / norm.value if norm.value > 0.0 else float("inf")
        results.append(RobustnessTest(name, OPERATORS[name], norm.value, tolerated, norm.frequency))
    return results


def singular_values(system: Realisation, omega: Array) -> Array:
    """Singular values over frequency, largest first, shape (k, min(p, m)), for plots."""
    return np.asarray(np.linalg.svd(response(system, omega), compute_uv=False), dtype=np.float64)


def _between(system: Realisation, outputs: range, inputs: range) -> Realisation:
    rows, columns = list(outputs), list(inputs)
    return Realisation(system.A, system.B[:, columns], system.C[rows], system.D[np.ix_(rows, columns)])


def _coprime(plant: Realisation, controller: Realisation) -> Realisation:
    """[K; I] S_e M^-1: y = G u + M^-1 w, where M^-1 has the states of G."""
    factors = coprime_factors(plant)
    a, b, c, d = factors.plant
    p, m = d.shape
    values, vectors = np.linalg.eigh(factors.R)
    root = (vectors * np.sqrt(values)) @ vectors.T
    whole = GeneralizedPlant(
        A=a, B1=-factors.H @ root, B2=b,
        C1=np.vstack((np.zeros((m, len(a))), c)), C2=c,
        D11=np.vstack((np.zeros((m, p)), root)),
        D12=np.vstack((np.eye(m), d)), D21=root, D22=d,
    )  # fmt: skip
    return lower_lft(whole, controller)
