"""A bag that shows the helicopter: `tf` is always in it, whether tf2_msgs is installed or not (spec 6.1)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from heli_common.body_frame import TF, TRANSFORM, is_shown, transform_message
from heli_common.topics import TOPICS
from heli_flight.bag import BagWriter

_TRUTH = TOPICS["ground_truth"]


class FramedBagWriter(BagWriter):
    """Writes the frame of every shown pose of `ground_truth` behind it; otherwise a `BagWriter`."""

    def __init__(
        self, folder: Path, custom_data: Mapping[str, str] | None = None, storage: str = "mcap"
    ) -> None:
        super().__init__(folder, custom_data, storage)
        self.add_topic(TF, TRANSFORM.ros_type)

    def write(self, topic: str, stamp_ns: int, data: bytes) -> None:
        """Append a serialized message, and the frame if it is due; as `BagWriter.write`."""
        super().write(topic, stamp_ns, data)
        if topic == _TRUTH.name and is_shown(stamp_ns):
            super().write(TF, stamp_ns, transform_message(stamp_ns, _TRUTH.layout.unpack(data)[1]))
