"""Messages as YAML and from YAML."""

import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import Imu, JointState
from std_srvs.srv import SetBool, Trigger

from heli_common.errors import InputError
from heli_flight.nodes.message_text import LONGEST, field_text, fill, message_yaml


def test_a_message_is_a_mapping_in_the_order_of_its_fields():
    message = JointState(name=["a"], position=[0.5])
    message.header.stamp.nanosec = 7
    assert message_yaml(message) == (
        "header:\n  stamp:\n    sec: 0\n    nanosec: 7\n  frame_id: ''\nname:\n- a\n"
        "position:\n- 0.5\nvelocity: []\neffort: []\n"
    )


def test_fixed_arrays_bytes_and_nested_messages():
    assert yaml.safe_load(message_yaml(Imu()))["orientation_covariance"] == [0.0] * 9
    array = DiagnosticArray(
        status=[DiagnosticStatus(level=b"\x02", values=[KeyValue(key="late", value="3")])]
    )
    (status,) = yaml.safe_load(message_yaml(array))["status"]
    assert (status["level"], status["values"]) == ("\x02", [{"key": "late", "value": "3"}])


def test_long_arrays_and_texts_end_in_dots():
    message = JointState(name=["n" * (LONGEST + 1)], position=[1.0] * (LONGEST + 1), velocity=[1.0] * LONGEST)
    shown = yaml.safe_load(message_yaml(message))
    assert shown["position"] == [*[1.0] * LONGEST, "..."]
    assert shown["velocity"] == [1.0] * LONGEST
    assert shown["name"] == ["n" * LONGEST + "..."]


def test_fields_by_dotted_names_and_indices():
    message = JointState(position=[1.0, 0.5])
    message.header.frame_id = "rig"
    assert field_text(message, "header.frame_id") == "rig\n"
    assert field_text(message, "position[1]") == "0.5\n"
    assert field_text(message, "header.stamp") == "sec: 0\nnanosec: 0\n"
    for field in ("head", "position[2]", "header.frame_id.x", "position[one]", "header[0]", ""):
        with pytest.raises(InputError):
            field_text(message, field)


def test_requests_are_filled_from_yaml():
    pose, array = PoseStamped(), DiagnosticArray()
    fill(pose, {"pose": {"position": {"x": 1, "z": -0.5}}, "header": {"frame_id": "world"}})
    assert (pose.pose.position.x, pose.pose.position.y, pose.pose.position.z) == (1.0, 0.0, -0.5)
    assert pose.header.frame_id == "world"
    fill(array, {"status": [{"name": "a", "values": [{"key": "k"}]}, {"name": "b", "level": 2}]})
    assert [status.name for status in array.status] == ["a", "b"]
    assert array.status[0].values == [KeyValue(key="k")]
    assert array.status[1].level == b"\x02"


@pytest.mark.parametrize(
    ("request_", "values", "place"),
    [
        (SetBool.Request(), {"dat": True}, "dat: no such field (allowed: data)"),
        (SetBool.Request(), {"data": 1}, "data: 1 (allowed: boolean)"),
        (SetBool.Request(), [1], "[1] (allowed: a mapping of data)"),
        (Trigger.Request(), {"data": True}, "data: no such field"),
        (PoseStamped(), {"pose": {"position": {"x": "far"}}}, "pose.position.x: 'far' (allowed: double)"),
        (DiagnosticArray(), {"status": [{"names": "a"}]}, "status[0].names: no such field"),
        (JointState(), {"position": [1, True]}, "position[1]: True (allowed: double)"),
        (JointState(), {"position": 1.0}, "position: 1.0 (allowed: sequence<double>)"),
        (JointState(), {"header": {"stamp": {"nanosec": -1}}}, "header.stamp.nanosec: -1 (allowed: uint32)"),
        (Imu(), {"orientation_covariance": [0.0]}, "orientation_covariance: 1 elements (allowed: double[9])"),
    ],
)
def test_wrong_fields_and_values_are_named(request_, values, place):
    with pytest.raises(InputError) as refusal:
        fill(request_, values)
    assert str(refusal.value).startswith(place)
