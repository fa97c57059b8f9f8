"""The supervisor against a helicopter that does exactly as told, and against one that does not."""

import dataclasses
import itertools
import math

import pytest

from heli_common.flight_state import FlightState
from heli_common.rotations import Euler
from heli_common.timing import CONTROL_PERIOD_NS
from heli_common.topics import TOPICS
from heli_common.vehicle_state import (
    UNKNOWN_VARIANCE,
    VehicleState,
    odometry_values,
    pose_from_values,
)
from heli_flight.plan import load_plan, parse_plan
from heli_flight.stages import FlightLimits
from heli_flight.supervisor import Supervisor

DEPTH = FlightLimits().rest_depth
EXCITATION = TOPICS["flight_state"].layout.fields.index("effort.flight_state")

EXCITED = """\
name: excited
about: Two excitations, one right after the other.
seed: 1
controller: lq
phases:
  - home: {}
  - run_up: {}
  - take_off: {}
  - hover: {duration: 1.0}
  - excite: {signal: noise, channel: B_1s, amplitude_deg: 0.5, band_rad_s: [1, 12], duration: 4.0}
  - excite: {signal: noise, channel: A_1s, amplitude_deg: 0.5, band_rad_s: [1, 12], duration: 3.0}
  - hover: {duration: 1.0}
  - land: {}
  - run_down: {}
"""


class Obedient:
    """A helicopter that is where the reference was, homes in two seconds and has an ideal drive."""

    def __init__(self, supervisor):
        self.supervisor = supervisor
        self.tick = 0
        self.position, self.rotor, self.known, self.tilt = (0.0, 0.0, DEPTH), 0.0, False, 0.0
        self.states, self.references, self.controllers, self.excitations = [], [], [], []
        self.variance = 1e-6

    def step(self):
        stamp = self.tick * CONTROL_PERIOD_NS
        variance = (self.variance if self.known else UNKNOWN_VARIANCE,) * 6
        zero = (0.0, 0.0, 0.0)
        vehicle = VehicleState(self.position, Euler(0.0, self.tilt, 0.0), zero, zero)
        assert self.supervisor.receive("rotor_state", stamp, (0.0, self.rotor, 0.0)) == []
        state, reference = self.supervisor.receive(
            "odometry", stamp, odometry_values(vehicle, variance, (1e-4,) * 6)
        )
        assert state.stamp_ns == reference.stamp_ns == stamp
        self.states.append(FlightState(int(state.values[0])))
        self.rotor = state.values[5]
        self.controllers.append(state.values[3])
        self.excitations.append(int(state.values[EXCITATION]))
        position, attitude = pose_from_values(reference.values)
        self.references.append((*position, attitude.psi))
        if self.states[-1].controlled:
            self.position = (position[0], position[1], min(position[2], DEPTH))
        self.known = self.known or self.tick > 200
        self.tick += 1
        return self.states[-1]

    def run(self, ticks=20_000):
        for _ in range(ticks):
            if self.step().ended:
                return self.states[-1]
        raise AssertionError(f"still {self.states[-1].word} after {ticks} ticks")


def stages(states):
    return [state for index, state in enumerate(states) if index == 0 or state is not states[index - 1]]


def test_hover_steps_goes_through_every_stage():
    plan = load_plan("hover_steps")
    flight = Obedient(Supervisor(FlightLimits(), plan))
    assert flight.run() is FlightState.STOPPED
    order = ["HOMING", "RUN_UP", "FLYING", "LANDING", "RUN_DOWN", "STOPPED"]
    assert [state.name for state in stages(flight.states)] == order
    assert len(flight.states) * 0.01 == pytest.approx(plan.duration, abs=5.0)
    assert flight.supervisor.phase == len(plan.phases)
    assert flight.rotor == 0.0


def test_references_of_the_steps_are_those_of_the_plan():
    flight = Obedient(Supervisor(FlightLimits(), load_plan("hover_steps")))
    flight.run()
    flown = [r for r, s in zip(flight.references, flight.states, strict=True) if s is FlightState.FLYING]
    steps = [
        tuple(round(b - a, 9) for a, b in zip(before[:2], after[:2], strict=True))
        for before, after in itertools.pairwise(flown)
        if before[:2] != after[:2]
    ]
    assert steps == [(0.3, 0.0), (-0.3, 0.0), (0.0, 0.3), (0.0, -0.3)]
    climb = [b[2] - a[2] for a, b in itertools.pairwise(flown)]
    assert min(climb) == pytest.approx(-0.15 * 0.01, abs=1e-9)


def test_the_controller_is_said_by_number_from_the_start_of_its_phase():
    plan = load_plan("hover_steps")
    home, run_up, take_off, hover, one, two, *rest = plan.phases
    one, two = dataclasses.replace(one, controller="gst"), dataclasses.replace(two, controller="lq")
    plan = dataclasses.replace(plan, phases=(home, run_up, take_off, hover, one, two, *rest))
    flight = Obedient(Supervisor(FlightLimits(), plan))
    flight.run()
    changes = [k for k, (a, b) in enumerate(itertools.pairwise(flight.controllers), 1) if a != b]
    assert [flight.controllers[k] for k in changes] == [1.0, 0.0]
    jumps = [k for k, (a, b) in enumerate(itertools.pairwise(flight.references), 1) if a[0] != b[0]]
    assert changes == jumps  # the steps themselves


def test_not_homed_is_not_flown():
    flight = Obedient(Supervisor(FlightLimits(), load_plan("hover_steps")))
    flight.known = False
    for _ in range(2_000):
        flight.known = False
        if flight.step().ended:
            break
        flight.known = False
    assert flight.states[-1] is FlightState.FAULT
    assert "not indexed" in flight.supervisor.reason


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"tilt": math.radians(23.0)}, "roll or pitch of 23.0 deg"),
        ({"position": (0.49, 0.0, 0.0)}, "0.49 m from the axis"),
        ({"known": False}, "position lost"),
        ({"rotor": 100.0}, "too low to fly"),
    ],
)
def test_an_unsafe_flight_is_stopped_with_the_reason(change, words):
    flight = Obedient(Supervisor(FlightLimits(), load_plan("short_hover")))
    while flight.step() is not FlightState.FLYING:
        pass
    flight.tick = 10_000  # known stays as set
    for name, value in change.items():
        setattr(flight, name, value)
    assert flight.step() is FlightState.FAULT
    assert words in flight.supervisor.reason
    assert flight.rotor == 0.0
    # and it stays stopped
    flight.tilt, flight.position, flight.known = 0.0, (0.0, 0.0, 0.0), True
    assert flight.step() is FlightState.FAULT


def test_a_position_that_gets_uncertain_is_landed_with_the_reason():
    helicopter = Obedient(Supervisor(FlightLimits(), load_plan("hover_steps")))
    while helicopter.step() is not FlightState.FLYING:
        pass
    helicopter.variance = 0.04**2
    assert helicopter.run() is FlightState.FAULT
    flown = [state.name for state in stages(helicopter.states)]
    assert flown[-4:] == ["FLYING", "LANDING", "RUN_DOWN", "FAULT"]
    assert helicopter.supervisor.reason.startswith("landed: position known to 40 mm only at ")


def test_a_position_that_is_lost_stops_the_flight_at_once():
    helicopter = Obedient(Supervisor(FlightLimits(), load_plan("hover_steps")))
    while helicopter.step() is not FlightState.FLYING:
        pass
    helicopter.variance = 0.2**2
    assert helicopter.step() is FlightState.FAULT
    assert "position known to 200 mm only" in helicopter.supervisor.reason


def test_services_fly_without_a_plan():
    flight = Obedient(Supervisor(FlightLimits()))
    command = flight.supervisor.command
    assert flight.step() is FlightState.IDLE
    assert command("arm") == (False, "arm is not possible while idle: home first")
    assert command("take_off")[0] is False
    for name, end in (
        ("home", FlightState.IDLE),
        ("arm", FlightState.RUN_UP),
        ("take_off", FlightState.FLYING),
    ):
        assert command(name)[0], name
        for _ in range(1_500):
            flight.step()
        assert flight.states[-1] is end
    assert command("home") == (False, "home is not possible while flying")
    assert command("land")[0]
    assert flight.run() is FlightState.STOPPED
    assert command("home") == (False, "the flight is over (stopped)")


def test_stop_is_always_accepted_and_acts_at_the_next_tick():
    flight = Obedient(Supervisor(FlightLimits(), load_plan("short_hover")))
    flight.step()
    assert flight.supervisor.command("home")[0] is False
    assert flight.supervisor.command("dance")[0] is False
    assert flight.supervisor.command("stop") == (True, "stopping")
    assert flight.step() is FlightState.FAULT
    assert flight.supervisor.reason == "stop requested at 0.01 s"


def test_flight_state_counts_the_excitations_of_the_plan():
    flight = Obedient(Supervisor(FlightLimits(), parse_plan(EXCITED)))
    assert flight.run() is FlightState.STOPPED
    assert [flight.excitations.count(number) for number in (1, 2)] == [400, 300]
    first = flight.excitations.index(1)
    assert flight.excitations[first - 1 : first + 701] == [0, *[1] * 400, *[2] * 300, 0]
    excited = {s for s, n in zip(flight.states, flight.excitations, strict=True) if n}
    assert excited == {FlightState.FLYING}
    here = flight.references[first - 1]
    assert flight.references[first : first + 700] == [here] * 700


@pytest.mark.parametrize("word", ["land", "stop"])
def test_an_excitation_cut_short_is_over(word):
    flight = Obedient(Supervisor(FlightLimits(), parse_plan(EXCITED)))
    while not flight.excitations or flight.excitations[-1] != 1:
        flight.step()
    assert flight.supervisor.command(word)[0]
    flight.step()
    assert flight.excitations[-1] == 0
    flight.run() if word == "land" else None
    assert flight.excitations.count(2) == 0
