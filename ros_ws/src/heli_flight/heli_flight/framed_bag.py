"""A bag that shows the helicopter: `tf` is always in it, whether tf2_msgs is installed or not (spec 6.1)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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

    def write_all(self, messages: Mapping[str, tuple[Sequence[int], Sequence[bytes]]]) -> None:
        """Append serialized messages, and the frames that are due; as `BagWriter.write_all`."""
        stamps, truths = messages.get(_TRUTH.name, ((), ()))
        shown = [(stamp, truth) for stamp, truth in zip(stamps, truths, strict=True) if is_shown(stamp)]
        if shown:
            frames = [transform_message(stamp, _TRUTH.layout.unpack(truth)[1]) for stamp, truth in shown]
            messages = {**messages, TF: ([stamp for stamp, _ in shown], frames)}
        super().write_all(messages)
