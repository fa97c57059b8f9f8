"""What a rosbag2 folder says about itself: metadata.yaml, version 9 (spec 6.3).

`custom_data` is rosbag2's own place for remarks, text to text. The keys of a flight:

| key | text |
|---|---|
| plan | the plan file as flown (YAML) |
| seed, mode | of the random numbers; way of running |
| controller, controller_file | names in the plan's order; their files as flown (YAML documents) |
| controllers | name, SHA-256 of the file's text and plant hash of each, JSON list |
| motor_file | the motor controller's file as flown (YAML) |
| parameters, versions | JSON objects |
| counts, losses | JSON objects, written by `BagWriter` itself and renewed with the metadata |
| jitter | real time: JSON object, per topic rms and largest deviation of the time between two arrivals [ms] |
| late_TOPIC | how many commands of a topic came too late |
| latency_TOPIC_ms | real time: median, quantiles and maximum from a sample to the command of its stamp [ms] |
| period_jitter_ms | real time: the same of how late the bench began its control periods |
| cores_kept_awake | real time: whether the bench could keep all cores from sleeping |
| pauses, paused_s | real time: how often and how long the bench itself was kept from running |
| repaired | what was wrong with the bag of which this one was made |
| left_out, sha256_with_left_out | topics that a copy does without; hash of the flight with them |
| result | why the flight ended, if not by its plan |
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from textwrap import indent
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

PACKED_SUFFIX = ".zstd"
"""Ending of a storage file that was compressed as a whole."""

METADATA_FILE = "metadata.yaml"
FLIGHT_RECORD_NAME = "heli_flight"
"""MCAP metadata record at the head of the file: the custom data known at the start."""
METADATA_VERSION = 9
ROS_DISTRO = "jazzy"
NO_START = 2**63 - 1
"""What rosbag2 writes as the starting time of an empty bag."""

_TOPICS = "topics_with_message_count"
_INDENT = 2 * " "
_FOREVER = {"sec": 9223372036, "nsec": 854775807}


def qos_profile(depth: int, transient_local: bool) -> dict[str, Any]:
    """A reliable publisher's quality of service in the words of metadata version 9."""
    return {
        "history": "keep_last",
        "depth": depth,
        "reliability": "reliable",
        "durability": "transient_local" if transient_local else "volatile",
        "deadline": dict(_FOREVER),
        "lifespan": dict(_FOREVER),
        "liveliness": "automatic",
        "liveliness_lease_duration": dict(_FOREVER),
        "avoid_ros_namespace_conventions": False,
    }


@dataclass
class RecordedTopic:
    """A topic in the making of a bag.

    Attributes:
        name: absolute name in the bag.
        ros_type: e.g. `sensor_msgs/msg/JointState`.
        type_hash: RIHS01 hash of the type.
        qos: profile, see `qos_profile`.
        period_ns: distance of two stamps, 0 if irregular.
        channel: number in the MCAP file.
        count: messages settled.
        last_ns: newest stamp, -1 before the first message.
        lost: messages missing between the first and the newest stamp.
        gaps: places where they are missing.
        stamps: of messages that wait to be settled.
        waiting: these messages.
    """

    name: str
    ros_type: str
    type_hash: str
    qos: dict[str, Any] = field(repr=False)
    period_ns: int = 0
    channel: int = 0
    count: int = 0
    last_ns: int = -1
    lost: int = 0
    gaps: int = 0
    stamps: list[int] = field(default_factory=list, repr=False)
    waiting: list[bytes] = field(default_factory=list, repr=False)

    @property
    def description(self) -> dict[str, Any]:
        """What `topic_metadata` says of it."""
        return {
            "name": self.name,
            "type": self.ros_type,
            "serialization_format": "cdr",
            "offered_qos_profiles": [self.qos],
            "type_description_hash": self.type_hash,
        }

    @cached_property
    def text(self) -> str:
        """The same as YAML, an entry of the list of topics without its count."""
        return indent(dump_yaml([{"topic_metadata": self.description}]), _INDENT)

    def count_in(self, stamps: NDArray[np.int64]) -> None:
        """Count messages with the next stamps [ns], and what is missing between them."""
        self.count += len(stamps)
        if self.period_ns:
            known = stamps if self.last_ns < 0 else np.concatenate(([self.last_ns], stamps))
            missing = np.diff(known) // self.period_ns - 1
            self.lost += int(missing[missing > 0].sum())
            self.gaps += int(np.count_nonzero(missing > 0))
        self.last_ns = int(stamps[-1])


class _Dumper(yaml.CSafeDumper if yaml.__with_libyaml__ else yaml.SafeDumper):  # type: ignore[misc]
    """Texts of several lines stay legible."""

    def ignore_aliases(self, data: object) -> bool:  # noqa: ARG002
        """Every profile is written in full: other readers know no anchors."""
        return True


def _represent_text(dumper: yaml.SafeDumper, text: str) -> yaml.ScalarNode:
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style="|" if "\n" in text else None)


_Dumper.add_representer(str, _represent_text)


def dump_yaml(document: object) -> str:
    """YAML text in the order given, block style, texts of several lines as blocks."""
    return str(yaml.dump(document, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=110))


def bag_information(
    storage_file: str,
    storage: str,
    topics: Iterable[RecordedTopic],
    start_ns: int,
    end_ns: int,
    custom_data: Mapping[str, str],
) -> dict[str, Any]:
    """The mapping below `rosbag2_bagfile_information`, all but the list of topics.

    Args:
        storage_file: name of the storage file in the folder.
        storage: `mcap` or `sqlite3`.
        topics: what has been recorded so far.
        start_ns: first stamp, `NO_START` of an empty bag.
        end_ns: last stamp.
        custom_data: text to text.
    """
    packed = storage_file.endswith(PACKED_SUFFIX)
    count = sum(topic.count for topic in topics)
    start = {"nanoseconds_since_epoch": start_ns}
    duration = {"nanoseconds": max(0, end_ns - start_ns)}
    return {
        "version": METADATA_VERSION,
        "storage_identifier": storage,
        "duration": duration,
        "starting_time": start,
        "message_count": count,
        "compression_format": "zstd" if packed else "",
        "compression_mode": "FILE" if packed else "",
        "relative_file_paths": [storage_file],
        "files": [
            {"path": storage_file, "starting_time": start, "duration": duration, "message_count": count}
        ],
        "custom_data": dict(custom_data),
        "ros_distro": ROS_DISTRO,
    }


def with_topics(information: Mapping[str, Any], topics: Iterable[RecordedTopic]) -> dict[str, Any]:
    """The whole mapping.

    Args:
        information: of `bag_information`.
        topics: those it was made of.
    """
    listed = [{"topic_metadata": topic.description, "message_count": topic.count} for topic in topics]
    return {**information, _TOPICS: listed}


def metadata_text(information: Mapping[str, Any], topics: Collection[RecordedTopic]) -> str:
    """The text of metadata.yaml: a dump of `with_topics`, made faster.

    It is renewed in flight, and what it says of each topic stays as it is but for the count.

    Args:
        information: of `bag_information`.
        topics: those it was made of.
    """
    lines = [dump_yaml({"rosbag2_bagfile_information": information}), f"{_INDENT}{_TOPICS}:"]
    lines.append("\n" if topics else " []\n")
    for topic in topics:
        lines += [topic.text, f"{2 * _INDENT}message_count: {topic.count}\n"]
    return "".join(lines)
