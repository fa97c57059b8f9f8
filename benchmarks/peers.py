"""Speed of two published simulators, for benchmarks/plant.py: one measurement per line that is read.

Needs neither this project nor its environment: run by any Python that has jsbsim and rotorpy (decision 4).
For every name read from standard input one JSON object is written: simulated seconds per CPU second and
what flew, or why nothing did.
"""

from __future__ import annotations

import importlib.metadata
import json
import math
import os
import sys
import time
from collections.abc import Callable
from typing import Any

RATE = 400.0
"""Steps per simulated second."""

SPEED = "simulated_s_per_cpu_s"

AH1S_PREPARATION = {
    "ap/afcs/psi-trim-rad": math.pi,
    "propulsion/tank[0]/contents-lbs": 0.0,
    "propulsion/tank[1]/contents-lbs": 0.0,
    "aero/setup/downwash-enable": 1.0,
    "aero/setup/Nr_limiter": 0.05,
    "fcs/adj/collective-profile": 0.0,
    "fcs/adj/center-sensitivity": 1.0,
}

AH1S_TAKE_OFF = (
    (1.0, 5.0, "fcs/rpm-governor-active-norm", 1.0),
    (10.0, 3.0, "fcs/collective-cmd-norm", 0.35),
    (10.0, 3.0, "fcs/rudder-cmd-norm", 0.35),
    (10.0, 3.0, "ap/afcs/yaw-channel-active-norm", 1.0),
    (15.0, 0.0, "ap/afcs/manual/phi-trim-rad", -0.049254),
    (15.0, 0.0, "ap/afcs/manual/theta-trim-rad", -0.006428),
    (15.0, 3.0, "ap/afcs/pitch-channel-active-norm", 1.0),
    (15.0, 3.0, "ap/afcs/roll-channel-active-norm", 1.0),
    (15.0, 3.0, "fcs/rudder-cmd-norm", 0.39),
    (15.0, 10.0, "fcs/collective-cmd-norm", 0.615),
    (15.0, 20.0, "fcs/elevator-cmd-norm", -0.18),
    (15.0, 20.0, "fcs/aileron-cmd-norm", 0.22),
    (40.0, 5.0, "fcs/elevator-cmd-norm", -0.1558),
    (40.0, 5.0, "fcs/aileron-cmd-norm", 0.19095),
)
"""Begin [s], ramp [s], property, target: what the shipped ah1s_flight_test.xml does until it hovers."""

AH1S_AIRBORNE = 60.0
"""Time from which on speed is measured [s]."""

Measurement = Callable[[], dict[str, Any]]


def jsbsim_ah1s() -> Measurement:
    """The AH-1S that JSBSim ships, airborne under its own autopilot, slow, engines and rotor turning.

    Only `run()` is timed: no script, no output, no property read.
    """
    import jsbsim

    jsbsim.FGJSBBase().debug_lvl = 0
    helicopter = jsbsim.FGFDMExec(None)
    helicopter.set_debug_level(0)
    helicopter.load_model("ah1s")
    helicopter.disable_output()
    helicopter.set_dt(1.0 / RATE)
    helicopter.load_ic("reset00", True)
    helicopter.run_ic()
    for name, value in AH1S_PREPARATION.items():
        helicopter[name] = value
    begun: dict[int, float] = {}
    while (now := helicopter.get_sim_time()) < AH1S_AIRBORNE:
        for index, (begin, ramp, name, target) in enumerate(AH1S_TAKE_OFF):
            if now < begin or now > begin + ramp + 2.0 / RATE:
                continue
            first = begun.setdefault(index, helicopter[name])
            share = min(1.0, (now - begin) / ramp) if ramp else 1.0
            helicopter[name] = first + share * (target - first)
        helicopter.run()

    def measure() -> dict[str, Any]:
        steps = int(10.0 * RATE)
        begin = time.process_time()
        for _ in range(steps):
            helicopter.run()
        used = time.process_time() - begin
        height, speed = helicopter["position/h-agl-ft"], helicopter["velocities/vc-kts"]
        rotor, power = helicopter["propulsion/engine/rotor-rpm"], helicopter["propulsion/engine/power-hp"]
        flight = f"{height:.0f} ft up at {speed:.0f} kt, rotor {rotor:.0f} rpm, {power:.0f} hp"
        return {SPEED: steps / RATE / used, "flight": flight}

    return measure


def rotorpy_quadrotor() -> Measurement:
    """RotorPy's Crazyflie hovering, its own step and integrator (SciPy's RK45), no controller."""
    import numpy as np
    from rotorpy.vehicles.crazyflie_params import quad_params
    from rotorpy.vehicles.multirotor import Multirotor

    vehicle = Multirotor(quad_params)
    speed = math.sqrt(quad_params["mass"] * vehicle.g / (vehicle.num_rotors * vehicle.k_eta))
    speeds = np.full(vehicle.num_rotors, speed)
    state = {
        "x": np.zeros(3),
        "v": np.array([0.3, -0.2, 0.0]),
        "q": np.array([0.0, 0.0, 0.0, 1.0]),
        "w": np.zeros(3),
        "wind": np.zeros(3),
        "rotor_speeds": speeds,
    }

    def measure() -> dict[str, Any]:
        steps = int(1.0 * RATE)
        now = dict(state)
        begin = time.process_time()
        for _ in range(steps):
            now = vehicle.step(now, {"cmd_motor_speeds": speeds}, 1.0 / RATE)
        used = time.process_time() - begin
        return {SPEED: steps / RATE / used, "flight": f"hovering, rotors {speed:.0f} rad/s"}

    return measure


PEERS = {"jsbsim": jsbsim_ah1s, "rotorpy": rotorpy_quadrotor}


def main() -> None:
    """Answer every line on standard input with one line on standard output."""
    # whatever a simulator writes shall not get between our lines
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    ready: dict[str, Measurement] = {}
    for line in sys.stdin:
        name = line.strip()
        try:
            if name not in ready:
                ready[name] = PEERS[name]()
            answer = ready[name]() | {"version": importlib.metadata.version(name)}
        except ImportError as error:
            answer = {"missing": str(error)}
        except Exception as error:  # another release of a peer may differ; that must not end the table
            answer = {"missing": f"{type(error).__name__}: {error}"}
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
