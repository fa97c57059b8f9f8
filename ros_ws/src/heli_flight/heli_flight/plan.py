"""A flight plan: what is flown, in a YAML file of phases, checked before anything moves.

```yaml
name: hover_steps
about: one sentence
seed: 1
controller: lq              # a shipped controller or a path
phases:
  - home: {}
  - run_up: {}
  - take_off: {height: 0.0, speed: 0.15}
  - hover: {duration: 10.0}
  - step: {axis: x, amplitude: 0.30, duration: 6.0}
  - step: {axis: psi, amplitude_deg: 20.0, duration: 6.0}
  - excite: {signal: prbs, channel: B_1s, amplitude_deg: 0.5, band_rad_s: [0.5, 12], duration: 60.0}
  - land: {}
  - run_down: {}
room: gusty                 # still (default), or gusty: the rotor's own air comes back from floor and ceiling
faults:                     # default none; `heli_bench_sim.fault_words` shows every kind
  - {kind: encoder_stuck, encoder: arm_1, at_s: 40.0, for_s: 2.0}
```

Every phase may carry `wind_m_s`, the speed asked of the fan from its start on, 0 .. 8 m/s. It is kept until
changed and is 0 at first. A phase with a duration may carry `wind_to_m_s` too: the speed asked for goes there
steadily while the phase lasts, as in `hover: {duration: 20.0, wind_m_s: 0.0, wind_to_m_s: 5.0}`.

Every phase may carry `controller`, a shipped controller or a path: from its start on that one flies, until
changed. The plan's own `controller` is the first.

Axes are those of the thesis: x ahead (north), y right (east), z down, psi about z. Steps are relative to the
reference before them. Heights are of the platform, above the centre of the flight space.
"""

from __future__ import annotations

import dataclasses
import json
import re
from dataclasses import dataclass
from pathlib import Path

import yaml

from heli_bench_sim.fault_words import fault_schedule, to_mappings
from heli_bench_sim.faults import Fault
from heli_common.errors import InputError
from heli_flight.bag_metadata import dump_yaml
from heli_flight.phase_words import phase_mapping, read_phase
from heli_flight.plan_file import controller_at, integer_at, read_mapping, read_text, refuse_unknown, text_at
from heli_flight.plan_phases import (
    Excite,
    Home,
    Hover,
    Land,
    Phase,
    RunDown,
    RunUp,
    Step,
    TakeOff,
    wind_command,
)
from heli_flight.plan_rules import check_faults, check_order, check_work_space
from heli_identification.excitation import Excitation
from heli_identification.excitation_words import excitation_mapping

__all__ = [
    "Excite",
    "Home",
    "Hover",
    "Land",
    "Phase",
    "Plan",
    "RunDown",
    "RunUp",
    "Step",
    "TakeOff",
    "load_plan",
    "parse_plan",
    "shipped_plans",
    "wind_command",
]

PLAN_FOLDER = Path(__file__).parent / "plans"

STOP_HEIGHT = -0.45
SETTLING_TIME = 3.0
"""What taking up the load and settling add to a take-off, in an estimate of the duration [s]."""

STILL, GUSTY = "still", "gusty"
ROOMS = (STILL, GUSTY)


@dataclass(frozen=True)
class Plan:
    """A checked plan.

    Attributes:
        name: of the flight, part of file names.
        about: one sentence for people.
        seed: of all random numbers.
        controller: that flies first: name of a shipped controller, or a path.
        phases: in the order of flying.
        room: `still`, or `gusty` with recirculation of the rotor's air.
        faults: that the bench shall have, in the order of the file.
    """

    name: str
    about: str
    seed: int
    controller: str
    phases: tuple[Phase, ...]
    room: str = STILL
    faults: tuple[Fault, ...] = ()

    @property
    def controllers(self) -> tuple[str, ...]:
        """Names or paths of all controllers, in the order in which they are first named."""
        named = (phase.controller for phase in self.phases if phase.controller is not None)
        return tuple(dict.fromkeys((self.controller, *named)))

    @property
    def duration(self) -> float:
        """Estimate of the flight's duration [s]; take-off and landing take what they need."""
        total, height = 0.0, STOP_HEIGHT
        for phase in self.phases:
            if isinstance(phase, TakeOff):
                total += (phase.height - height) / phase.speed + SETTLING_TIME
                height = phase.height
            elif isinstance(phase, Land):
                total += (height - STOP_HEIGHT) / phase.speed
            else:
                total += phase.duration
                if isinstance(phase, Step) and phase.axis == "z":
                    height -= phase.amplitude
        return total

    @property
    def excitations(self) -> tuple[Excitation, ...]:
        """Of the excite phases, in order."""
        return tuple(phase.excitation for phase in self.phases if isinstance(phase, Excite))

    @property
    def excitations_text(self) -> str:
        """The same as JSON, for the identification's parameter."""
        return json.dumps([excitation_mapping(excitation) for excitation in self.excitations])

    def to_yaml(self) -> str:
        """The plan as a file that reads back to an equal plan."""
        head = {"name": self.name, "about": self.about, "seed": self.seed, "controller": self.controller}
        room = {} if self.room == STILL else {"room": self.room}
        text = dump_yaml(head | room) + _listed("phases", [phase_mapping(phase) for phase in self.phases])
        return text + (_listed("faults", to_mappings(self.faults)) if self.faults else "")


def _listed(key: str, entries: list[dict[str, object]]) -> str:
    """A list of mappings, one line each where it holds no list itself."""
    texts = [yaml.safe_dump(entry, default_flow_style=None, sort_keys=False, width=1000) for entry in entries]
    return f"{key}:\n" + "".join("  - " + "\n    ".join(text.splitlines()) + "\n" for text in texts)


def shipped_plans() -> dict[str, Path]:
    """The plans that come with this package, by name."""
    return {path.stem: path for path in sorted(PLAN_FOLDER.glob("*.yaml"))}


def load_plan(name_or_path: str | Path) -> Plan:
    """A shipped plan by its name, or any plan by its path.

    Raises:
        InputError: no such plan, or something in it is wrong.
    """
    shipped, given = shipped_plans(), str(name_or_path)
    path = shipped.get(given, Path(given))
    if given not in shipped and not path.is_file():
        problem = "no such file" if path.suffix in (".yaml", ".yml") or path.parent != Path() else "unknown"
        raise InputError(f"plan {given!r}: {problem}", allowed=f"a path, or one of {', '.join(shipped)}")
    return parse_plan(read_text(path), str(path))


def parse_plan(text: str, file: str | None = None) -> Plan:
    """A plan from the text of its file.

    Args:
        text: YAML.
        file: named in errors.

    Raises:
        InputError: names the file, the key, the value and what is allowed.
    """
    document = read_mapping(text, file)
    refuse_unknown(document, [field.name for field in dataclasses.fields(Plan)], file, "")
    name = text_at(document, "name", file)
    if not re.fullmatch(r"[A-Za-z0-9_-]{1,60}", name):
        allowed = "up to 60 letters, digits, _ and -"
        raise InputError(f"{name!r} is no name", allowed=allowed, file=file, key="name")
    seed = integer_at(document, "seed", 0, 2**32 - 1, file)
    about_it, controller = text_at(document, "about", file), controller_at(document, file)
    entries = document.get("phases")
    if not isinstance(entries, list) or not entries:
        raise InputError(f"{entries!r} is no list of phases", allowed="- home: {}", file=file, key="phases")
    phases = tuple(read_phase(entry, file, f"phases[{index}]") for index, entry in enumerate(entries))
    check_order(phases, file)
    check_work_space(phases, file)
    room = document.get("room", STILL)
    if room not in ROOMS:
        raise InputError(f"{room!r} is no room", allowed=", ".join(ROOMS), file=file, key="room")
    faults = fault_schedule(document.get("faults", []), file=file, key="faults").faults
    plan = Plan(name, about_it, seed, controller, phases, room, faults)
    check_faults(faults, plan.duration, file)
    return plan
