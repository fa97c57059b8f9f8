"""Rig and helicopter for RViz and Foxglove: `markers` always, `tf` where tf2_msgs is installed (spec 6.1).

Both are made from what the bench says on its topics, at most 20 times a second and only while somebody looks.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress

from geometry_msgs.msg import Point
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from heli_bench_sim.bench_parameters import BenchParameters
from heli_bench_sim.rig_picture import Disc, Line, Picture, draw
from heli_common.body_frame import TF, TRANSFORM, is_shown, transform_message
from heli_common.component import Message
from heli_common.layout import Values
from heli_common.nodes.messages import message_class, time_message
from heli_common.rotations import Vector3
from heli_common.vehicle_state import WORLD_FRAME, pose_from_values, swap_earth

SHOWN = QoSProfile(depth=10)

ROD = 0.015
"""Thickness of lines and discs in the picture [m]."""

_COLOURS = {
    "base": (0.35, 0.35, 0.35, 1.0),
    "upper_arms": (0.55, 0.55, 0.60, 1.0),
    "forearms": (0.70, 0.70, 0.75, 1.0),
    "platform": (0.35, 0.35, 0.35, 1.0),
    "gimbal": (0.90, 0.60, 0.10, 1.0),
    "helicopter": (0.10, 0.30, 0.70, 1.0),
    "rotor_disc": (0.10, 0.30, 0.70, 0.3),
    "tail_rotor_disc": (0.10, 0.30, 0.70, 0.3),
    "wind": (0.10, 0.65, 0.30, 0.9),
}


class RigDisplay:
    """Publishers of the picture.

    Args:
        node: the bench's.
        parameters: of the bench.
    """

    def __init__(self, node: Node, parameters: BenchParameters) -> None:
        self._parameters = parameters
        self._markers = node.create_publisher(MarkerArray, "markers", SHOWN)
        self._frames: Publisher | None = None
        with suppress(ImportError):  # the bag has the frames all the same
            self._frames = node.create_publisher(message_class(TRANSFORM.ros_type), TF, SHOWN)

    def show(self, stamp_ns: int, messages: Iterable[Message]) -> None:
        """Show what the messages of one sample say, if it is time and anybody looks."""
        if not is_shown(stamp_ns):
            return
        said = {message.topic: message.values for message in messages}
        truth, wind = said["ground_truth"], said["wind"]
        if self._frames is not None and self._frames.get_subscription_count():
            self._frames.publish(transform_message(stamp_ns, truth))
        if self._markers.get_subscription_count():
            self._markers.publish(marker_array(stamp_ns, self._picture(truth, wind)))

    def _picture(self, truth: Sequence[float] | Values, wind: Sequence[float] | Values) -> Picture:
        position, attitude = pose_from_values([float(part) for part in truth[:7]])
        air = swap_earth((float(wind[0]), float(wind[1]), float(wind[2])))
        return draw(position, attitude, air, self._parameters.geometry, self._parameters.helicopter)


def marker_array(stamp_ns: int, picture: Picture) -> MarkerArray:
    """A marker for each part, in the world frame."""
    shown = [_lines(part, lines) for part, lines in picture.lines]
    shown += [_disc(disc) for disc in picture.discs]
    shown.append(_arrow(picture.wind))
    for marker in shown:
        marker.header.stamp = time_message(stamp_ns)
    return MarkerArray(markers=shown)


def _marker(part: str, kind: int) -> Marker:
    red, green, blue, opacity = _COLOURS[part]
    marker = Marker(ns=part, type=kind, action=Marker.ADD)
    marker.header.frame_id = WORLD_FRAME
    marker.color = ColorRGBA(r=red, g=green, b=blue, a=opacity)
    marker.scale.x = ROD
    return marker


def _lines(part: str, lines: Sequence[Line]) -> Marker:
    marker = _marker(part, Marker.LINE_LIST)
    marker.points = [_point(end) for line in lines for end in line]
    return marker


def _disc(disc: Disc) -> Marker:
    marker = _marker(disc.part, Marker.CYLINDER)
    marker.pose.position = _point(disc.centre)
    turned = marker.pose.orientation
    turned.x, turned.y, turned.z, turned.w = disc.attitude
    marker.scale.x = marker.scale.y = disc.diameter
    marker.scale.z = ROD
    return marker


def _arrow(wind: Line) -> Marker:
    """From tail to tip; in still air there is none."""
    marker = _marker("wind", Marker.ARROW)
    marker.points = [_point(end) for end in wind]
    marker.scale.y = 3.0 * ROD
    if wind[0] == wind[1]:
        marker.action = Marker.DELETE
    return marker


def _point(at: Vector3) -> Point:
    return Point(x=at[0], y=at[1], z=at[2])
