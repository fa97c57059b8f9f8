"""What each node of a flight is told, for `heli fly` and the launch file alike."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass, field

from heli_bench_sim.fault_words import to_mappings
from heli_common import topics
from heli_flight.mode import Mode
from heli_flight.order import FlightOrder
from heli_flight.plan import GUSTY, Plan
from heli_flight.process_table import Process, usable_cores

Settings = dict[str, str | int | float]


@dataclass(frozen=True)
class FlightSettings:
    """The ROS parameters of every node of one flight.

    Attributes:
        plan: what is flown; None waits for services.
        plan_name: name of a shipped plan or path of a plan file.
        mode: `realtime` or `lockstep`.
        seed: of every random number.
        controllers: names or paths, the one that flies first before those that the plan changes to.
        motor: name or path of the motor controller.
        plant: hash of the plant that controllers must be for, empty for any.
        bag: folder to record into, empty for none.
        notes: file of what the bag shall carry.
        storage: way of storing the bag, see `bag.STORAGES`.
        scheduled: whether real-time scheduling is asked for.
        cores: on which nodes that have a process of their own may run.
    """

    plan: Plan | None
    plan_name: str
    mode: str
    seed: int
    controllers: tuple[str, ...]
    motor: str = "motor"
    plant: str = ""
    bag: str = ""
    notes: str = ""
    storage: str = "mcap"
    scheduled: bool = True
    cores: tuple[int, ...] = field(default_factory=usable_cores)

    @classmethod
    def of_order(cls, order: FlightOrder, notes: str) -> FlightSettings:
        """Those of an order; its bag shall carry the notes in a file."""
        return cls(
            plan=order.plan,
            plan_name=order.plan_name,
            mode=(Mode.REALTIME if order.mode.paced else Mode.LOCKSTEP).value,
            seed=order.seed,
            controllers=(order.controller_name, *order.later_names),
            motor=order.motor_name,
            plant=order.plant,
            bag=str(order.bag),
            notes=notes,
            storage=order.storage,
            scheduled=order.real_time_scheduling,
            cores=() if order.mode.composed else usable_cores(),
        )

    def of(self, process: Process, running: Iterable[str]) -> Settings:
        """Parameters of one node.

        Args:
            process: of the table.
            running: names of the nodes of the flight.
        """
        common: Settings = {"running": ",".join(running), "real_time_priority": 0}
        if self.scheduled:
            common |= process.scheduling(self.mode == Mode.REALTIME.value, self.cores)
        own: dict[str, Settings] = {
            topics.BENCH_SIM: self._of_bench(),
            topics.SUPERVISOR: {"plan": self.plan_name},
            topics.MOTOR_CONTROLLER: {"controller": self.motor},
            topics.ATTITUDE_CONTROLLER: {
                "controller": self.controllers[0],
                "plan_controllers": ",".join(self.controllers),
                "plant": self.plant,
            },
            topics.IDENTIFICATION: {"excitations": self.plan.excitations_text if self.plan else ""},
            topics.RECORDER: {"bag": self.bag, "notes": self.notes, "storage": self.storage},
        }
        return common | own.get(process.name, {})

    def _of_bench(self) -> Settings:
        """What the bench must know of a plan: its room and its faults."""
        settings: Settings = {"mode": self.mode, "seed": self.seed}
        if self.plan and self.plan.faults:
            settings["faults"] = json.dumps(to_mappings(self.plan.faults))
        if self.plan and self.plan.room == GUSTY:
            settings["room.active"] = 1.0
        return settings
