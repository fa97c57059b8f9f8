"""Parameters: provenance and range of every one, the two shipped sets."""

import dataclasses
import math

import pytest

from heli_bench_sim.bench_parameters import BenchParameters
from heli_bench_sim.parameters import PARAMETER_SETS, HelicopterParameters, constants, physical_tail, thesis
from heli_common.errors import InputError
from heli_common.quantities import about, from_mapping
from heli_common.records import as_dict

GROUPS = [type(getattr(BenchParameters(), field.name)) for field in dataclasses.fields(BenchParameters)]


@pytest.mark.parametrize("group", GROUPS)
def test_every_parameter_tells_unit_source_meaning_and_range(group: type) -> None:
    for field in dataclasses.fields(group):
        known = about(field)
        assert known.unit, field.name
        assert known.text, field.name
        assert known.minimum <= field.default <= known.maximum, field.name
        assert math.isfinite(known.minimum) and math.isfinite(known.maximum), field.name


def test_shipped_sets_lie_within_the_ranges() -> None:
    for make in PARAMETER_SETS.values():
        parameters = make()
        values = dataclasses.asdict(parameters)
        assert from_mapping(HelicopterParameters, values) == parameters


def test_the_two_sets_differ_where_spec_says() -> None:
    first, second = dataclasses.asdict(thesis()), dataclasses.asdict(physical_tail())
    changed = {name for name in first if first[name] != second[name]}
    assert changed == {
        "tail_side_flow",
        "hub_x",
        "tail_z",
        "tail_x",
        "tail_efficiency",
        "speed_flapping",
        "inertia_zz",
    }


def test_constants_are_all_floats() -> None:
    derived = constants(thesis())
    groups = {name: value for name, value in as_dict(derived).items() if not isinstance(value, float)}
    assert set(groups) == {"levers", "h_force"}
    for group in groups.values():
        assert all(isinstance(value, float) for value in as_dict(group).values())


def test_unknown_and_wild_values_are_refused() -> None:
    with pytest.raises(InputError, match="unknown parameter"):
        from_mapping(HelicopterParameters, {"wings": 2.0})
    with pytest.raises(InputError, match="mass"):
        from_mapping(HelicopterParameters, {"mass": -1.0})
