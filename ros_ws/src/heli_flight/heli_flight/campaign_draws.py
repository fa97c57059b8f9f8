"""What one flight of a campaign is: everything drawn for it from the campaign's seed and its number alone."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from heli_bench_sim.faults import Fault
from heli_common.errors import InputError
from heli_flight.parameter_file import NodeValues, yaml_number
from heli_flight.plan import Plan
from heli_flight.plan_phases import Phase, commands_wind
from heli_flight.plan_rules import check_faults
from heli_flight.vary_file import CONTROLLER, ROOM, WIND_KEY, Vary, known_parameters

_AFTER_TAKE_OFF = 3
"""Place of the first phase after home, run_up and take_off."""


@dataclass(frozen=True)
class Drawn:
    """One flight.

    Attributes:
        number: of the flight, from 0.
        plan: with its seed, controller, wind, room and faults.
        parameters: numbers that differ from the defaults, by node and name.
        varied: value of every name that varies, as results show it.
        faults: the faults drawn, by their kinds.
    """

    number: int
    plan: Plan
    parameters: Mapping[str, Mapping[str, float]]
    varied: Mapping[str, Any]
    faults: tuple[Fault, ...] = ()

    @property
    def values(self) -> NodeValues:
        """The same for the nodes."""
        return NodeValues(self.parameters)

    @property
    def parameter_file(self) -> str:
        """The same as a ROS 2 parameter file; a comment alone if nothing differs."""
        lines = ["# Parameters of one flight of a campaign; all others have their defaults.\n"]
        for node, values in self.parameters.items():
            lines.append(f"/**/{node}:\n  ros__parameters:\n")
            lines += [f"    {name}: {yaml_number(value)}\n" for name, value in values.items()]
        if not self.parameters:
            lines.append("{}\n")
        return "".join(lines)


def check_campaign(plan: Plan, vary: Vary) -> None:
    """Refuse a vary file that does not fit the plan.

    Raises:
        InputError: wind is varied and the plan asks for wind itself, controllers are varied and the plan
            changes its controller, or a fault would begin after the flight.
    """
    if WIND_KEY in vary.names and any(commands_wind(phase) for phase in plan.phases):
        allowed = "a plan without wind_m_s"
        raise InputError(f"varied, but plan {plan.name} has wind of its own", allowed=allowed, key=WIND_KEY)
    if CONTROLLER in vary.names and len(plan.controllers) > 1:
        allowed = "a plan with one controller"
        raise InputError(
            f"varied, but plan {plan.name} has {len(plan.controllers)}", allowed=allowed, key=CONTROLLER
        )
    check_faults(tuple(fault for fault, _ in vary.faults), plan.duration, None)


def draw(plan: Plan, vary: Vary, number: int) -> Drawn:
    """Everything of one flight; flights of one grid round share their draws.

    Args:
        plan: that is flown.
        vary: what varies.
        number: of the flight, from 0.
    """
    turn, cell = divmod(number, vary.cells)
    drawn = cell_values(vary, cell)
    for name, choice in vary.choices.items():
        drawn[name] = choice.draw(_generator(vary.seed, turn, name))
    for name, distribution in vary.numbers.items():
        drawn[name] = distribution.draw(_generator(vary.seed, turn, name))
    faults = tuple(
        fault
        for index, (fault, probability) in enumerate(vary.faults)
        if float(_generator(vary.seed, turn, f"fault {index}").random()) < probability
    )
    seed = int(_generator(vary.seed, turn, "flight").integers(2**31))
    phases = plan.phases
    if WIND_KEY in drawn:
        phases = _with_wind(phases, drawn[WIND_KEY])
    own = replace(
        plan,
        seed=seed,
        phases=phases,
        controller=drawn.get(CONTROLLER, plan.controller),
        room=drawn.get(ROOM, plan.room),
        faults=plan.faults + faults,
    )
    parameters: dict[str, dict[str, float]] = {}
    for column, known in _KNOWN.items():
        if column in drawn:
            parameters.setdefault(known.node, {})[known.name] = drawn[column]
    return Drawn(number, own, parameters, {name: drawn[name] for name in vary.names}, faults)


def cell_values(vary: Vary, cell: int) -> dict[str, Any]:
    """The combination of one cell of the grid; the name written last changes fastest."""
    values: dict[str, Any] = {}
    for name, given in reversed(list(vary.grid.items())):
        cell, place = divmod(cell, len(given))
        values[name] = given[place]
    return {name: values[name] for name in vary.grid}


_KNOWN = known_parameters()


def _with_wind(phases: tuple[Phase, ...], wind: float) -> tuple[Phase, ...]:
    before, first, after = phases[:_AFTER_TAKE_OFF], phases[_AFTER_TAKE_OFF], phases[_AFTER_TAKE_OFF + 1 :]
    return (*before, replace(first, wind=wind), *after)


def _generator(seed: int, turn: int, name: str) -> np.random.Generator:
    """A stream of its own for each name, so that one more of them changes none of the others."""
    digest = hashlib.sha256(name.encode()).digest()
    words = tuple(int.from_bytes(digest[k : k + 4], "little") for k in range(0, 16, 4))
    # PCG64 by name: what numpy takes by default may change
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=(turn, *words))))
