"""What `heli fly` and `heli verify` both read from their words: plan, seed, controllers, parameters."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from heli_control.controller_file import load_controller
from heli_flight.cli.limits import require_between
from heli_flight.mode import Mode
from heli_flight.order import FlightOrder
from heli_flight.plan import load_plan


def planned_order(
    name: str, seed: int | None, parameters: Path | None, controller: str = "", plant: str = ""
) -> FlightOrder:
    """The order of a plan, in this process; its bag has no place yet.

    Args:
        name: of a shipped plan, or path of a plan file.
        seed: in place of the plan's.
        parameters: ROS 2 parameter file for the nodes.
        controller: in place of the plan's first one; shipped, or a file.
        plant: hash of the plant that controllers must be for, empty for any.

    Raises:
        InputError: one of them is not allowed.
    """
    plan = load_plan(name)
    if seed is not None:
        require_between(seed, 0, 2**31 - 1, "--seed")
        plan = replace(plan, seed=seed)
    names = (controller or plan.controller, *plan.controllers[1:])
    first, *later = [load_controller(each, plant) for each in names]
    if parameters is not None:
        from heli_flight.parameter_file import read_parameters  # loads what every node is made of

        read_parameters(parameters)
    return FlightOrder(
        plan=plan,
        plan_name=absolute(name),
        mode=Mode.INPROCESS,
        seed=plan.seed,
        controller=first,
        controller_name=absolute(names[0]),
        bag=Path(),
        parameters=parameters.absolute() if parameters else None,
        later=tuple(later),
        later_names=tuple(absolute(each) for each in names[1:]),
        plant=plant,
    )


def absolute(name_or_path: str) -> str:
    """A path as the nodes need it, wherever they run; a shipped name as it is."""
    return str(Path(name_or_path).absolute()) if Path(name_or_path).is_file() else name_or_path
