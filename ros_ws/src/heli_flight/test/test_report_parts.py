"""What the flight report draws and counts: envelopes, spectra, ellipses, commands, errors, sampling."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import synthetic_flight as synthetic
from hypothesis import given
from hypothesis import strategies as st

from heli_flight.decimation import thinned
from heli_flight.estimation_error import estimation_errors
from heli_flight.flight_hash import count_check
from heli_flight.flight_record import FlightRecord
from heli_flight.flight_statistics import SERVO_LIMITS, controlled
from heli_flight.graph_pictures import graph_canvas
from heli_flight.hover_figures import ellipse, hover_deviation, hover_graph
from heli_flight.metrics import flight_metrics
from heli_flight.picture import save_png, save_svg
from heli_flight.plan import load_plan
from heli_flight.report import summarized
from heli_flight.report_tables import difference_table
from heli_flight.spectrum_figures import amplitude_spectrum
from heli_flight.step_figures import step_graph


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> FlightRecord:
    """A made-up flight with steps."""
    folder = tmp_path_factory.mktemp("parts") / "steps"
    synthetic.write_flight(folder, load_plan("hover_steps"))
    return FlightRecord.load(folder)


def test_a_long_curve_keeps_its_one_peak() -> None:
    x = np.arange(10_000.0)
    y = np.zeros(10_000)
    y[4321], y[4322] = 7.0, -3.0
    some_x, some_y = thinned(x, y, 100)
    assert len(some_x) <= 100 and some_y.max() == 7.0 and some_y.min() == -3.0
    assert (some_x[0], some_x[-1]) == (0.0, 9999.0)
    same_x, same_y = thinned(x[:100], y[:100], 100)
    assert same_x is not None and len(same_y) == 100
    with pytest.raises(ValueError, match="5 points"):
        thinned(x, y, 5)


@given(st.integers(1, 3000), st.integers(6, 200), st.floats(0.0, 0.9), st.integers(0, 99))
def test_thinned_curves_are_made_of_their_own_points(n: int, most: int, gaps: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y = np.arange(float(n)), rng.normal(size=n)
    y[rng.random(n) < gaps] = np.nan
    some_x, some_y = thinned(x, y, most)
    assert len(some_x) <= max(most, min(n, most))
    assert np.all(np.diff(some_x) > 0)
    assert np.array_equal(some_y, y[some_x.astype(int)], equal_nan=True)
    if np.isfinite(y).any():
        assert (np.nanmin(some_y), np.nanmax(some_y)) == (np.nanmin(y), np.nanmax(y))


def test_a_sine_stands_at_its_frequency_with_its_power() -> None:
    stamps = np.arange(6000) * 10_000_000
    values = 3.0 * np.sin(2.0 * np.pi * 5.0 * stamps * 1e-9)
    found = amplitude_spectrum(stamps, values)
    assert found is not None
    frequencies, density = found
    assert frequencies[np.argmax(density)] == pytest.approx(5.0, abs=0.05)
    power = float(np.sum(density**2) * (frequencies[1] - frequencies[0]))
    assert power == pytest.approx(4.5, rel=0.02)
    missing = np.delete(stamps, slice(1000, 1003)), np.delete(values, slice(1000, 1003))
    assert amplitude_spectrum(*missing) is not None
    assert amplitude_spectrum(stamps[:100], values[:100]) is None
    assert amplitude_spectrum(stamps, np.zeros(6000)) is None


def test_the_ellipse_holds_95_percent() -> None:
    cloud = np.random.default_rng(2).multivariate_normal([1.0, -2.0], [[4.0, 1.5], [1.5, 1.0]], 20_000)
    edge = ellipse(cloud)
    assert edge[0] == pytest.approx(edge[-1])
    away = cloud - cloud.mean(axis=0)
    distance = np.einsum("ij,jk,ik->i", away, np.linalg.inv(np.cov(cloud.T)), away)
    assert np.mean(distance <= 2.4477**2) == pytest.approx(0.95, abs=0.005)
    out = edge - cloud.mean(axis=0)
    size = np.einsum("ij,jk,ik->i", out, np.linalg.inv(np.cov(cloud.T)), out)
    assert size == pytest.approx(2.4477**2)


def test_hover_planes_have_the_same_scale_and_hold_all(record: FlightRecord) -> None:
    graph = hover_graph([record], ["steps"])
    assert graph is not None
    (plots,) = graph.rows
    assert len({plot.x_range for plot in plots} | {plot.y_range for plot in plots}) == 1
    assert plots[0].x_range is not None
    assert np.abs(hover_deviation(record)).max() < plots[0].x_range[1]
    for save in (save_png, save_svg):
        assert save(graph_canvas(graph)) == save(graph_canvas(graph))


def test_steps_go_from_nothing_to_all(record: FlightRecord) -> None:
    graph = step_graph([record], ["steps"])
    assert graph is not None
    response, _, angle, command = (plot for row in graph.rows for plot in row)
    assert [curve.label[:8] for curve in response.curves[:4]] == [
        "x +30 cm",
        "x −30 cm",
        "y +30 cm",
        "y −30 cm",
    ]
    for curve in response.curves[:4]:
        assert abs(curve.y[0]) < 20.0 and curve.y[-1] == pytest.approx(100.0, abs=20.0)
    for curve in (*angle.curves, *command.curves):
        assert abs(curve.y[curve.x < 0.0][-1]) < 1e-9


def test_commands_are_judged_against_their_limits(record: FlightRecord) -> None:
    stamps, angles = record.servo_command
    inside = controlled(record, stamps)
    commands = {one["channel"]: one for one in flight_metrics(record)["commands"]}
    assert list(commands) == ["B_1s", "A_1s", "theta_0", "theta_t", "motor"]
    assert commands["theta_0"]["mean_rad"] == pytest.approx(angles[inside, 2].mean())
    assert commands["theta_0"]["upper_limit_rad"] == SERVO_LIMITS[2][1] == math.radians(16.0)
    assert commands["motor"]["at_limit_percent"] == 0.0


def test_errors_are_estimate_less_truth(record: FlightRecord) -> None:
    errors = {error.name: error for error in estimation_errors(record)}
    assert list(errors) == ["x", "y", "z", "theta", "phi", "psi", "u", "v", "w", "p", "q", "r"]
    assert errors["x"].values.std() == pytest.approx(1e-3, rel=0.1)
    assert errors["x"].sigma == pytest.approx(1e-3) and errors["u"].sigma == pytest.approx(1e-2)
    assert np.abs(errors["theta"].values).max() < 1e-12
    (x, *_) = flight_metrics(record)["estimation"]
    assert x["inside_two_sigma_percent"] == pytest.approx(95.4, abs=1.5)


def test_sampling_names_the_hole(tmp_path: Path) -> None:
    writer = synthetic.write_flight(tmp_path / "flight", until=4.001, close=False)
    writer.write("rotor", 4_050_000_000, synthetic.TOPICS["rotor"].layout.pack(4_050_000_000, (0.0,) * 3))
    writer.close()
    record = FlightRecord.load(tmp_path / "flight")
    (summary,) = summarized([record], [count_check(record.bag)]).summaries
    topics = {topic["topic"]: topic for topic in summary["sampling"]}
    # 3.99 s is the last tick that is whole
    assert topics["rotor"]["lost"] == 5 and topics["rotor"]["first_gap_s"] == pytest.approx(4.0)
    assert topics["rotor"]["longest_pause_s"] == pytest.approx(0.06)
    assert topics["imu"]["rate_hz"] == pytest.approx(400.0) == topics["imu"]["nominal_rate_hz"]


def test_only_parameters_that_differ_are_listed() -> None:
    table = difference_table(
        [{"name": "one"}, {"name": "two"}], [{"a": {"b": 1, "c": 2}}, {"a": {"b": 1, "c": 3}, "d": 4}]
    )
    assert [[cell.text for cell in row] for row in table.rows] == [["a.c", "2", "3"], ["d", "–", "4"]]
    assert table.header == ("parameter", "one", "two") and "Of 3 parameters" in table.note
