"""How stiffly a controller holds the helicopter against slow gusts, from its file, beside what was flown.

A gust slower than the loop pushes until the controller pushes back. In the plane the push comes from tilt:
the controller balances K_theta theta against K_u (u_ref - u), so a velocity error is answered by a tilt
K_u / K_theta times as large. Up and down and about yaw the collectives push themselves: K_w, K_r. The
deviation goes with the inverse, at the corner frequency of the gusts; friction, drag and the position
loop's integral are left out.
"""

from __future__ import annotations

import cmath

import numpy as np

from heli_bench_sim.room_air import RoomAirParameters
from heli_common.linear_model import StateSpace
from heli_common.timing import CONTROL_PERIOD
from heli_control.controller_file import ControllerFile, load_controller
from heli_flight.page_tables import TEXT, Cell, Table, number
from heli_flight.published_flights import HOVER, TITLES
from heli_flight.reproduction_results import AXES, SIGMAS, Outcomes, flown_controllers, hover_figure
from heli_flight.reproduction_statistics import paired_ratio

Four = tuple[float, float, float, float]


def stiffness(controller: ControllerFile, frequency: float) -> Four:
    """Tilt per velocity error ahead and right [rad s/m], collective per velocity down, tail per yaw rate.

    Args:
        controller: any that measures theta, phi, u, v, w, r.
        frequency: of the gust [rad/s].
    """
    horizontal, vertical = controller.horizontal.system, controller.vertical.system
    return (
        _gain(horizontal, "B_1s", "u", frequency) / _gain(horizontal, "B_1s", "theta", frequency),
        _gain(horizontal, "A_1s", "v", frequency) / _gain(horizontal, "A_1s", "phi", frequency),
        _gain(vertical, "theta_0", "w", frequency),
        _gain(vertical, "theta_t", "r", frequency),
    )


def _gain(law: StateSpace, command: str, measured: str, frequency: float) -> float:
    row, column = law.outputs.index(command), law.inputs.index(measured)
    turn = cmath.exp(1j * frequency * CONTROL_PERIOD)
    answer = np.linalg.solve(turn * np.eye(len(law.states)) - law.A, law.B[:, column])
    return float(abs(law.C[row] @ answer + law.D[row, column]))


def stiffness_table(outcomes: Outcomes) -> Table:
    """Deviation over that of LQ: from the controllers' gains, as flown, and as the source prints it."""
    frequency = 1.0 / RoomAirParameters().correlation_time
    lq = stiffness(load_controller("lq"), frequency)
    cells = []
    for name in flown_controllers(outcomes, "F2"):
        if name == "lq":
            continue
        own = stiffness(load_controller(name), frequency)
        for place, axis in enumerate(AXES):
            found = paired_ratio(
                hover_figure(outcomes, name, SIGMAS[place]), hover_figure(outcomes, "lq", SIGMAS[place])
            )
            printed = HOVER[name][place] / HOVER["lq"][place] if name in HOVER else None
            cells.append(
                (
                    Cell(TITLES.get(name, name), TEXT),
                    Cell(axis),
                    Cell(number(lq[place] / own[place])),
                    Cell(number(None if found is None else found.mean)),
                    Cell(number(printed)),
                )
            )
    note = (
        f"At {frequency:.2f} rad/s, the corner of the gusts. x and y: inverse of velocity gain over attitude "
        "gain; z and psi: inverse of the gain on w and r."
    )
    header = ("controller", "axis", "from the gains", "flown", "published")
    return Table("Deviation over that of LQ, from the controllers' gains alone", note, header, tuple(cells))
