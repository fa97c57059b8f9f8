"""The identification in flight: excitations sent at their time, and the running estimate (spec 4, 6.1).

An excitation begins at the control tick at which `flight_state` says that the plan's excitation of its number
is flown, or at the next tick after a request, and its sample n goes out n ticks later. It is stopped for good
when the guard objects.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from heli_common import topics
from heli_common.component import Message, StampJoin
from heli_common.errors import InputError
from heli_common.finite import require_finite
from heli_common.flight_state import FlightState, flight_state_from_code
from heli_common.timing import CONTROL_PERIOD, ESTIMATE_PERIOD_NS
from heli_common.topics import TOPICS
from heli_common.vehicle_state import VehicleState, pose_from_values, state_from_odometry, twist_values
from heli_identification.excitation import CHANNELS, COMMAND_CHANNELS, Excitation, samples
from heli_identification.excitation_guard import GuardParameters, objection
from heli_identification.excitation_words import excitation_from_text
from heli_identification.running_estimate import EstimateParameters, RunningEstimate

_STATE = TOPICS["flight_state"].layout.fields.index("position.flight_state")
_NUMBER = TOPICS["flight_state"].layout.fields.index("effort.flight_state")
_COMMANDS = len(COMMAND_CHANNELS)
_NOTHING = (0.0,) * len(CHANNELS)


class _Run:
    """One excitation being sent."""

    def __init__(self, table: NDArray[np.float64], release_time: float) -> None:
        self._table = table
        self._index = 0
        self._share = 1.0
        self._fall = 0.0
        self._release = CONTROL_PERIOD / release_time

    def stop(self) -> None:
        """Fade out from the next sample on."""
        self._fall = self._release

    @property
    def stopping(self) -> bool:
        """Whether it has been stopped."""
        return self._fall > 0.0

    def step(self) -> tuple[float, ...] | None:
        """The sample of this tick in the order of `CHANNELS`; None when it is over."""
        self._share = max(0.0, self._share - self._fall)
        if self._index >= len(self._table) or self._share == 0.0:
            return None
        row = self._share * self._table[self._index]
        self._index += 1
        return tuple(row.tolist())


class Identifier:
    """Component: odometry, reference, flight state and servo command in; excitations and estimate out.

    Args:
        plan: the excitations of the flight's plan, in order.
        guard: limits of an excitation.
        estimate: memory and delay of the running estimate.

    Attributes:
        remarks: what people should be told: level and text, the oldest in front; whoever tells it empties it.
    """

    name = topics.IDENTIFICATION
    inputs: tuple[str, ...] = ("odometry", "reference", "flight_state", "servo_command")
    outputs: tuple[str, ...] = ("excitation", "reference_excitation", "motor_excitation", "estimate")

    def __init__(
        self,
        plan: Sequence[Excitation] = (),
        guard: GuardParameters | None = None,
        estimate: EstimateParameters | None = None,
    ) -> None:
        self.remarks: list[tuple[str, str]] = []
        self._plan = tuple(plan)
        self._tables = {excitation: samples(excitation) for excitation in self._plan}  # not while flying
        self._guard = guard or GuardParameters()
        self._estimate = RunningEstimate(estimate or EstimateParameters())
        self._join = StampJoin(("odometry", "reference", "flight_state"))
        self._number = 0
        self._stage = FlightState.IDLE
        self._requested: Excitation | None = None
        self._run: _Run | None = None
        self._sent: dict[int, tuple[VehicleState, tuple[float, ...], bool]] = {}

    def receive(self, topic: str, stamp_ns: int, values: Sequence[float]) -> list[Message]:
        """Take in one message; excitations follow the state of a stamp, the estimate its servo command.

        Raises:
            ValueError: another topic, a number that is not finite, no such flight state, or an excitation
                that the plan does not hold.
        """
        require_finite(topic, values)
        if topic == "servo_command":
            return self._learn(stamp_ns, values)
        ready = self._join.add(topic, stamp_ns, values)
        if ready is None:
            return []
        state = state_from_odometry(ready["odometry"])
        self._stage = flight_state_from_code(ready["flight_state"][_STATE])
        reference, _ = pose_from_values(ready["reference"])
        self._begin(round(ready["flight_state"][_NUMBER]))
        self._watch(objection(self._stage, state, reference, self._guard))
        row = self._next_row()
        command, (ahead, right, down, turn, voltage) = row[:_COMMANDS], row[_COMMANDS:]
        excited = self._run is not None and self._stage is FlightState.FLYING
        self._sent[stamp_ns] = (state, command, excited)
        return [
            Message("excitation", stamp_ns, (*command, *(0.0,) * 2 * _COMMANDS)),
            Message("reference_excitation", stamp_ns, twist_values((ahead, right, down), (0.0, 0.0, turn))),
            Message("motor_excitation", stamp_ns, (0.0, 0.0, voltage)),
        ]

    def request(self, text: str) -> None:
        """An excitation asked for in flight; acts at the next control tick. An empty text stops what acts.

        Args:
            text: as in a plan, e.g. `{signal: chirp, channel: B_1s, ...}`.

        Raises:
            InputError: it is not allowed, nothing flies, or an excitation acts already.
        """
        if not text.strip():
            if self._run is not None:
                self._stop("asked to stop")
            return
        excitation = excitation_from_text(text)
        if self._stage is not FlightState.FLYING:
            allowed = "while flying"
            raise InputError(f"not possible while {self._stage.word}", allowed=allowed, key="excite")
        if self._number or self._run is not None or self._requested is not None:
            raise InputError("an excitation acts already", allowed="one after the other", key="excite")
        self._requested = excitation

    def _begin(self, number: int) -> None:
        if number > len(self._plan):
            raise ValueError(f"excitation {number} is flown, but {len(self._plan)} are known")
        started = self._requested
        if number not in (self._number, 0):
            started = self._plan[number - 1]
        self._number, self._requested = number, None
        if started is not None:
            table = self._tables[started] if started in self._tables else samples(started)
            self._run = _Run(table, self._guard.release_time)
            self.remarks.append(("ok", f"{started.signal} on {', '.join(started.channels)} begins"))

    def _watch(self, reason: str) -> None:
        if reason and self._run is not None:
            self._stop(reason)

    def _stop(self, reason: str) -> None:
        if self._run is not None and not self._run.stopping:
            self._run.stop()
            self.remarks.append(("warn", f"excitation stopped: {reason}"))

    def _next_row(self) -> tuple[float, ...]:
        row = self._run.step() if self._run is not None else None
        if row is None:
            self._run = None
        return row or _NOTHING

    def _learn(self, stamp_ns: int, values: Sequence[float]) -> list[Message]:
        sent = self._sent.pop(stamp_ns, None)
        for stamp in [stamp for stamp in self._sent if stamp < stamp_ns]:
            del self._sent[stamp]
        if sent is not None:
            state, excitation, excited = sent
            applied = [asked + added for asked, added in zip(values[:_COMMANDS], excitation, strict=True)]
            self._estimate.step(state, applied, excited)
        if stamp_ns % ESTIMATE_PERIOD_NS:
            return []
        estimate, error = self._estimate.estimate, self._estimate.standard_error
        message = (*estimate.tolist(), *(0.0,) * len(estimate), *error.tolist())
        return [Message("estimate", stamp_ns, message)]
