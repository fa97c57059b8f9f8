"""Joins, time grid, parameters with units, strict files and the cache folder."""

import dataclasses
from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heli_common.component import StampJoin
from heli_common.errors import InputError
from heli_common.files import file_hash, read_yaml, write_atomically
from heli_common.flight_state import FlightState, flight_state_from_code
from heli_common.kernel_cache import cache_folder, source_hash
from heli_common.quantities import from_mapping, quantity
from heli_common.rig_geometry import RADIAN_PER_COUNT, RigGeometry
from heli_common.timing import (
    CONTROL_PERIOD_NS,
    SENSOR_PERIOD_NS,
    is_command_tick,
    is_control_tick,
    is_pwm_tick,
)


@dataclass(frozen=True)
class Spring:
    stiffness: float = quantity(10.0, "N/m", "D", "of the spring", 0.0, 100.0)


def test_time_grid_of_one_pwm_frame():
    ticks = [k * SENSOR_PERIOD_NS for k in range(8)]
    assert [k for k in range(8) if is_control_tick(ticks[k])] == [0, 4]
    assert [k for k in range(8) if is_command_tick(ticks[k])] == [2, 6]
    assert [k for k in range(8) if is_pwm_tick(ticks[k])] == [2]
    assert CONTROL_PERIOD_NS == 4 * SENSOR_PERIOD_NS


@given(st.permutations([("a", stamp) for stamp in range(5)] + [("b", stamp) for stamp in range(5)]))
def test_a_join_does_not_depend_on_how_its_inputs_interleave(order):
    # per topic, stamps arrive in order: sort each topic's share, keep the interleaving
    stamps = {topic: iter(range(5)) for topic in "ab"}
    join = StampJoin(["a", "b"])
    joined = []
    for topic, _ in order:
        stamp = next(stamps[topic])
        complete = join.add(topic, stamp, (float(stamp),))
        if complete is not None:
            joined.append((stamp, sorted(complete)))
    assert joined == [(stamp, ["a", "b"]) for stamp in range(5)]
    assert join.dropped == 0


def test_a_join_forgets_what_can_no_longer_be_completed():
    join = StampJoin(["a", "b"])
    assert join.add("a", 0, ()) is None
    assert join.add("a", 1, ()) is None
    assert join.add("b", 1, ()) is not None
    assert join.dropped == 1
    with pytest.raises(ValueError, match="none of"):
        join.add("c", 0, ())


def test_an_optional_topic_is_waited_for_while_it_comes():
    join = StampJoin(["a", "b"], ["c"])
    assert join.add("a", 1, (1.0,)) is None
    assert join.add("b", 1, (2.0,)) is None
    assert join.add("c", 1, (3.0,)) == {"a": (1.0,), "b": (2.0,), "c": (3.0,)}
    assert join.stamp_ns == 1


def test_a_lost_optional_topic_costs_a_few_late_stamps_and_then_nothing():
    join = StampJoin(["a", "b"], ["c"])
    given_at = {}
    for stamp in range(10):
        join.add("a", stamp, (float(stamp),))
        entry = join.add("b", stamp, (float(stamp),))
        if entry is not None:
            assert entry["a"] == (float(join.stamp_ns),)
            given_at[stamp] = join.stamp_ns
    assert given_at == {1: 0, 2: 1, 3: 2, 4: 3, **{stamp: stamp for stamp in range(5, 10)}}
    assert join.dropped == 1


def test_an_optional_topic_that_is_back_is_waited_for_again():
    join = StampJoin(["a"], ["c"])
    for stamp in range(10):
        join.add("a", stamp, (0.0,))
    assert join.add("c", 10, (1.0,)) is None
    assert join.add("a", 10, (0.0,)) == {"a": (0.0,), "c": (1.0,)}
    assert join.add("a", 11, (0.0,)) is None
    assert join.add("c", 11, (1.0,)) == {"a": (0.0,), "c": (1.0,)}


def test_parameters_are_checked_against_their_quantity():
    assert from_mapping(Spring, {"stiffness": 5}) == Spring(5.0)
    for bad in (-1.0, 101.0, float("nan"), "stiff", True, 10**400):
        with pytest.raises(InputError) as refused:
            from_mapping(Spring, {"stiffness": bad}, file="spring.yaml")
        assert "spring.yaml: stiffness" in str(refused.value)
        assert "0 .. 100 N/m" in str(refused.value)
    with pytest.raises(InputError, match="unknown parameter"):
        from_mapping(Spring, {"damping": 1.0})
    with pytest.raises(ValueError, match="provenance"):
        quantity(1.0, "m", "X", "of unknown origin")


def test_rig_geometry_by_hand():
    rig = RigGeometry()
    assert rig.rest_depth == pytest.approx(0.45)
    assert rig.fold_height == pytest.approx(0.356, abs=5e-4)
    assert pytest.approx(0.0031415927) == RADIAN_PER_COUNT
    assert all("quantity" in field.metadata for field in dataclasses.fields(rig))


def test_flight_states_have_codes_and_words():
    assert [flight_state_from_code(float(state)) for state in FlightState] == list(FlightState)
    assert FlightState.RUN_UP.word == "run-up"
    assert [state for state in FlightState if state.ended] == [FlightState.STOPPED, FlightState.FAULT]
    for code in (-1.0, 8.0, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="flight state code"):
            flight_state_from_code(code)


def test_yaml_is_a_mapping_or_one_clear_line(tmp_path):
    path = tmp_path / "x.yaml"
    for text, words in (("a: [1", "not valid YAML"), ("- 1\n", "not a mapping"), ("", "not a mapping")):
        path.write_text(text)
        with pytest.raises(InputError) as refused:
            read_yaml(path)
        assert words in str(refused.value)
        assert str(path) in str(refused.value)
        assert "\n" not in str(refused.value)
    with pytest.raises(InputError, match="cannot be read"):
        read_yaml(tmp_path / "absent.yaml")


def test_a_file_is_complete_or_absent(tmp_path):
    path = tmp_path / "new" / "x.yaml"
    write_atomically(path, "a: 1\n")
    assert read_yaml(path) == {"a": 1}
    assert [child.name for child in path.parent.iterdir()] == ["x.yaml"]
    before = file_hash(path)
    with pytest.raises(TypeError):
        write_atomically(path, None)  # type: ignore[arg-type]
    assert file_hash(path) == before
    assert [child.name for child in path.parent.iterdir()] == ["x.yaml"]


def test_the_cache_is_named_by_every_source(monkeypatch, tmp_path):
    assert len(source_hash()) == 64
    monkeypatch.setenv("HELI_CACHE", str(tmp_path))
    assert cache_folder().parent == tmp_path / "heli_bench"
    assert source_hash()[:16] in cache_folder().name
