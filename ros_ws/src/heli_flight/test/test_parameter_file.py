"""The committed parameter file: what the code says, and what the nodes accept."""

from dataclasses import fields
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from heli_bench_sim.bench_parameters import BenchParameters
from heli_common.errors import InputError
from heli_common.quantities import from_mapping
from heli_common.rig_geometry import RigGeometry
from heli_control.position_control import PositionParameters
from heli_flight.components import bench_simulator
from heli_flight.parameter_file import NODE_PARAMETERS, parameter_file, read_parameters, yaml_number
from heli_flight.process_table import NODE_NAMES

COMMITTED = Path(__file__).parents[3] / "config" / "parameters.yaml"


def test_the_committed_file_is_what_the_code_says():
    assert COMMITTED.read_text() == parameter_file(), (
        "run: heli parameters --out ros_ws/config/parameters.yaml"
    )


def test_it_reads_back_to_the_defaults_of_every_node():
    document = yaml.safe_load(parameter_file())
    assert set(NODE_PARAMETERS) < set(NODE_NAMES)
    for node, groups in NODE_PARAMETERS.items():
        values = document[f"/**/{node}"]["ros__parameters"]
        for prefix, group in groups:
            names = {field.name for field in fields(group)}
            own = {key.removeprefix(prefix): value for key, value in values.items() if key.startswith(prefix)}
            if not prefix:
                own = {key: value for key, value in own.items() if "." not in key}
            assert set(own) == names
            assert from_mapping(type(group), own) == group


def test_group_defaults_are_the_defaults_of_their_classes():
    # the node declares class defaults, the in-process flight builds group defaults: they must not differ
    for field in fields(BenchParameters):
        group = getattr(BenchParameters(), field.name)
        assert group == type(group)()


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_survive_yaml(value):
    assert yaml.safe_load(yaml_number(value)) == value
    assert isinstance(yaml.safe_load(yaml_number(value)), float)


def test_what_a_file_changes_reaches_the_components(tmp_path):
    path = tmp_path / "heavy.yaml"
    path.write_text(
        "/**/bench_sim: {ros__parameters: {helicopter.mass: 7.5}}\n"
        "position_controller: {ros__parameters: {gain_x: 1.5}}\n"
        "/**/navigation: {ros__parameters: {rig: {upper_arm: 0.8}}}\n"
    )
    values = read_parameters(path)
    bench = bench_simulator(1, values).bench.parameters
    assert bench.helicopter.mass == 7.5
    assert bench.helicopter.radius == BenchParameters().helicopter.radius
    assert values.build("position_controller", PositionParameters) == PositionParameters(gain_x=1.5)
    assert values.build("navigation", RigGeometry, "rig.").upper_arm == 0.8


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("autopilot: {ros__parameters: {}}", ("autopilot", "unknown node", "bench_sim")),
        ("bench_sim: {mass: 1.0}", ("bench_sim", "ros__parameters")),
        ("bench_sim: {ros__parameters: {helicopter.mas: 1.0}}", ("helicopter.mas", "helicopter.mass")),
        ("bench_sim: {ros__parameters: {helicopter.mass: -1.0}}", ("helicopter.mass", "-1.0", "kg")),
        ("bench_sim: {ros__parameters: {helicopter.mass: heavy}}", ("helicopter.mass", "heavy", "kg")),
    ],
)
def test_a_wrong_file_is_refused_by_name(tmp_path, text, words):
    path = tmp_path / "wrong.yaml"
    path.write_text(text)
    with pytest.raises(InputError) as refused:
        read_parameters(path)
    for word in ("wrong.yaml", *words):
        assert word in str(refused.value)
