"""Electric drive: supply, motor torque and rotor speed (source sec. 2.3.3, eq. 2.48, 2.49, 2.51, 2.52)."""

from __future__ import annotations

from heli_bench_sim.parameters import Constants
from heli_common.compiled import equation


@equation
def current(u_mot: float, omega: float, c: Constants) -> float:
    """Current that the supply drives through the motor [A], 0 .. supply limit; it cannot brake.

    Args:
        u_mot: control voltage of the supply [V].
        omega: rotor speed [rad/s].
        c: constants of the helicopter.
    """
    voltage = min(max(c.supply_gain * u_mot, 0.0), c.supply_voltage)
    free = (voltage - c.torque_constant * c.motor_gear * omega) / c.armature_resistance
    return min(max(free, 0.0), c.supply_current)


@equation
def torque_rate(m_a: float, current: float, c: Constants) -> float:
    """M_A' [N m/s]: the motor torque follows the current with one lag.

    Args:
        m_a: motor torque [N m].
        current: motor current [A].
        c: constants of the helicopter.
    """
    return (c.torque_constant * current - m_a) / c.motor_time


@equation
def rotor_acceleration(m_a: float, torque: float, tail_torque: float, c: Constants) -> float:
    """Omega' [rad/s^2] of everything that turns, seen from the main rotor shaft.

    Args:
        m_a: motor torque [N m].
        torque: main rotor torque Q [N m].
        tail_torque: tail rotor torque Q_t on its own shaft [N m].
        c: constants of the helicopter.
    """
    return (c.motor_gear * m_a - torque - c.tail_gear * tail_torque) / c.drive_inertia
