"""The helicopter's frame on `tf`: the true pose in the world, for RViz and Foxglove (spec 6.1, 6.4).

It repeats what `ground_truth` says, so it is no data topic and no part of a flight's hash.
"""

from __future__ import annotations

from collections.abc import Sequence

from heli_common import standard_layouts
from heli_common.layout import Values
from heli_common.vehicle_state import BODY_FRAME, WORLD_FRAME

TF = "tf"
"""Relative, as every name: in a namespace, tools are told `--ros-args -r /tf:=tf`."""

TRANSFORM = standard_layouts.transform(WORLD_FRAME, BODY_FRAME)

SHOWN_PERIOD_NS = 50_000_000
"""Distance of two frames and of two pictures of the rig: enough for eyes."""

_POSE = 7


def is_shown(stamp_ns: int) -> bool:
    """Whether frame and picture of this stamp are due."""
    return stamp_ns % SHOWN_PERIOD_NS == 0


def transform_message(stamp_ns: int, truth: Sequence[float] | Values) -> bytes:
    """A serialized tf2_msgs/TFMessage.

    Args:
        stamp_ns: of the pose [ns].
        truth: numbers of `ground_truth`, ENU/FLU, which begin with position [m] and quaternion.
    """
    return TRANSFORM.pack(stamp_ns, truth[:_POSE])
