"""A controller node of your own: heli fly hover_steps --replace attitude_controller=my_controller_node.py."""

from contextlib import suppress
from math import asin, atan2, cos, sin

import numpy as np
import rclpy
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.executors import ExternalShutdownException
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import String

NAMES, TRIM = ["B_1s", "A_1s", "theta_0", "theta_t"], np.array([0.0065, 0.0005, 0.1691, 0.1946])  # [rad]
IDLE, LIMITS = np.radians([0, 0, 1, 4]), np.radians([[-10, -10, -4, -5], [10, 10, 16, 25]])
CYCLIC = np.array([  # LQ gains on theta phi u v q p, then on the last two commands of B_1s and A_1s
    [-1.355, 0.103, 0.157, 0.015, -0.037, 0.004, -0.229, 0.006, -0.216, -0.003],
    [-0.320, -0.751, 0.038, -0.111, -0.015, -0.010, -0.014, -0.276, -0.036, -0.179]])  # fmt: skip
COLLECTIVE = np.array([[0.058, 0.0], [0.037, 0.085]])  # on w and r
waiting, past, authority = {}, np.zeros(4), 0.0


def receive(message):
    """Join the three inputs on their stamp, then answer; messages are ENU and FLU, the gains FRD."""
    global past, authority
    joined = waiting.setdefault(str(message.header.stamp), {})
    joined[type(message)] = message
    if len(joined) < 3:
        return
    odometry, reference = joined[Odometry], joined[TwistStamped].twist
    q, v, w = odometry.pose.pose.orientation, odometry.twist.twist.linear, odometry.twist.twist.angular
    phi = atan2(2 * (q.w * q.x + q.y * q.z), 1 - 2 * (q.x**2 + q.y**2))
    theta = -asin(2 * (q.w * q.y - q.z * q.x))
    left = reference.linear.y * cos(phi) + reference.linear.z * sin(phi)  # pitch is small
    up = reference.linear.z * cos(phi) - reference.linear.y * sin(phi)
    errors = [theta + 0.0069, phi + 0.0944, v.x - reference.linear.x, left - v.y, -w.y, w.x, *past]
    asked = np.concatenate((CYCLIC @ errors, COLLECTIVE @ [up - v.z, reference.angular.z - w.z]))
    controlled = joined[JointState].position[0] in (3, 4)  # flying, landing: the rotor takes the load up
    authority = min(1, authority + 0.005) if controlled else max(0, authority - 0.01)
    sent = IDLE + authority * (np.clip(TRIM + asked, *LIMITS) - IDLE)
    past = np.concatenate(((sent - TRIM)[:2], past[:2]))
    answer = JointState(name=NAMES, position=sent.tolist(), velocity=[0.0] * 4, effort=[0.0] * 4)
    answer.header.frame_id, answer.header.stamp = "rig", odometry.header.stamp
    command.publish(answer)
    waiting.clear()


rclpy.init()
node, latched = rclpy.create_node("attitude_controller"), DurabilityPolicy.TRANSIENT_LOCAL
command = node.create_publisher(JointState, "servo_command", 1000)
ready = node.create_publisher(String, "ready", QoSProfile(depth=1, durability=latched))
for kind, topic in (Odometry, "odometry"), (TwistStamped, "velocity_reference"), (JointState, "flight_state"):
    node.create_subscription(kind, topic, receive, 1000)
with suppress(KeyboardInterrupt, ExternalShutdownException):
    while command.get_subscription_count() < 2:  # bench and recorder
        rclpy.spin_once(node, timeout_sec=0.05)
    ready.publish(String(data="attitude_controller mine"))  # the bench begins when every node has said so
    rclpy.spin(node)
