"""Report of an identification: what it says of a known model, its files, both kinds of page."""

import json
from pathlib import Path

import numpy as np
import pytest

from heli_common.errors import InputError
from heli_flight.graph_pictures import graph_png, plotly_graph
from heli_flight.identification import Choice, Identified
from heli_flight.identification_figures import comparison_graph, pole_graph, residual_graph
from heli_flight.identification_report import graphs, write_identification_report
from heli_flight.identification_tables import coefficient_table, fit_table, pole_table, residual_table
from heli_identification.helicopter_structures import SERVO_ROTOR
from heli_identification.identified_model import prior_model
from heli_identification.linear_twin import Disturbance, Twin, lq_feedback
from heli_identification.prediction_error import prediction_error
from heli_identification.validation import fit

TRUTH = SERVO_ROTOR.with_values({"X_u": -1.07, "Y_v": -1.19}).with_free(("X_u", "M_q", "M_1", "L_p", "L_2"))


@pytest.fixture(scope="module")
def found() -> Identified:
    process = np.array([0.0, 0.0, 0.003, 0.003, 0.01, 0.01, 0.0, 0.0])
    noise = Disturbance(process, np.array([0.001, 0.001, 0.005, 0.005, 0.01, 0.01]))
    twin = Twin(TRUTH, lq_feedback(TRUTH, 0.01), noise, 0.01)
    rng = np.random.default_rng(1)
    signs = rng.choice([-1.0, 1.0], size=(500, 2))
    record = twin.fly(0.015 * np.repeat(signs, 8, axis=0), rng, "flight")
    first, rest = record.piece(0, 1900), record.piece(1900, 4000)
    estimate = prediction_error(TRUTH, [first])
    judged = fit(estimate.structure, [rest])
    means = dict.fromkeys((*TRUTH.inputs, *TRUTH.outputs), 0.0)
    return Identified(Choice(), estimate, (first,), means, judged, ("flight 0-19",), ("flight 19-40",))


def test_the_figures_hold_what_was_found(found: Identified) -> None:
    made = graphs(found, prior_model().horizontal)
    assert [graph.key for group in made.values() for graph in group] == [
        *("comparison", "poles", "residuals", "magnitude", "phase", "coherence")
    ]
    theta = comparison_graph(found).rows[0][0]
    measured, simulated = theta.curves
    assert measured.y[:2000] == pytest.approx(np.degrees(found.fit.measured[:2000, 0]))
    # two segments; the line breaks where a simulation ends
    assert np.flatnonzero(np.isnan(simulated.y)).tolist() == [999, 1999]
    crosses = [curve for curve in pole_graph(found, None).rows[0][0].curves if curve.label == "identified"]
    assert sorted(crosses[0].x) == pytest.approx(sorted(found.estimate.structure.model().poles.real))
    own = residual_graph(found).rows[4][0]
    residual = found.estimate.residuals[0][:, 4]
    residual = residual - residual.mean()
    assert own.curves[0].y[0] == pytest.approx(residual[1:] @ residual[:-1] / (residual @ residual))
    assert own.limits[1] == pytest.approx(1.96 / np.sqrt(1900), rel=1e-3)
    magnitude = made["responses"][0].rows[4][0]
    spectrum, model = (
        next(curve for curve in magnitude.curves if curve.label == label) for label in ("spectrum", "model")
    )
    # q by B_1s from data alone lies on the model in the middle of the band
    band = (model.x > 3.0) & (model.x < 15.0)
    assert np.max(np.abs(spectrum.y[band] - model.y[band])) < 2.0


def test_the_tables_hold_what_was_found(found: Identified) -> None:
    table = coefficient_table(found, SERVO_ROTOR)
    rows = {row[0].text: [cell.text for cell in row] for row in table.rows}
    assert table.header[-4:] == (
        *("prior", "source: full information", "source: with servo rotor", "source: linearised"),
    )
    assert rows["M_q"][-4:] == ["−13.81", "−21.81", "−3.7446", "−13.81"]
    assert rows["k"][3] == "fixed" and rows["X_1"][-3:] == ["–"] * 3
    place = found.estimate.names.index("M_q")
    assert float(rows["M_q"][3]) == pytest.approx(found.estimate.errors[place], rel=0.06)
    assert fit_table(found).rows[-1][1].text == f"{found.fit.percent[0]:.1f}"
    assert len(pole_table(found, SERVO_ROTOR.model()).rows) <= 8
    white = [cell.mark for row in residual_table(found).rows for cell in row[2:]]
    assert found.estimate.white and white.count("good") >= 0.8 * len(white)


def test_both_kinds_of_page(found: Identified, tmp_path: Path) -> None:
    live = write_identification_report(found, {"fit": 1.0}, tmp_path / "live", prior_model())
    page = live.page.read_text()
    assert live.pictures == () and "Plotly.newPlot" in page and 'id="plot-poles"' in page
    assert json.loads((tmp_path / "live" / "identification.json").read_text()) == {"fit": 1.0}
    still = write_identification_report(found, {}, tmp_path / "still", static=True)
    page = still.page.read_text()
    assert len(still.pictures) == 6 and "<script" not in page and page.count("data:image/png") == 6
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in still.pictures)
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        write_identification_report(found, {}, tmp_path / "file")


def test_pictures_are_the_same_every_time(found: Identified) -> None:
    graph = pole_graph(found, None)
    assert graph_png(graph) == graph_png(graph)
    drawn = json.loads(plotly_graph(graph))
    assert sum(trace.get("showlegend", False) for trace in drawn["data"]) == 2
