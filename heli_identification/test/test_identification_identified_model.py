"""The model file of an estimate: read back, designed from, with its provenance."""

import json
from pathlib import Path

import numpy as np
import pytest
from closed_loop_data import TRUTH, flown

from heli_common.model_file import ModelFile
from heli_control.lq import LqWeights, design_lq
from heli_identification.helicopter_structures import BAR_GAIN, DRIVE, SERVO_ROTOR, VERTICAL
from heli_identification.identified_model import (
    SOURCE_TRIM,
    block_of,
    described,
    identified_model,
    number,
    operating_point,
    prior_model,
)
from heli_identification.prediction_error import Estimate, prediction_error
from heli_identification.records import Record, data_hash
from heli_identification.validation import fit


@pytest.fixture(scope="module")
def flight() -> Record:
    return flown(1, 20.0)


@pytest.fixture(scope="module")
def estimate(flight: Record) -> Estimate:
    return prediction_error(TRUTH, [flight])


def test_file_survives_and_feeds_the_design(tmp_path: Path, estimate: Estimate, flight: Record) -> None:
    judged = fit(estimate.structure, [flown(2, 10.0)])
    means = {"theta": -0.02, "B_1s": 0.01, "u": 0.3}
    model = identified_model("flown", estimate, [flight], means, remarks={"estimation": "pem"}, fit=judged)
    path = tmp_path / "flown.yaml"
    model.write(path)
    read = ModelFile.read(path)
    assert read.plant_hash == model.plant_hash and read.source == dict(model.source)
    assert read.horizontal.outputs == ("theta", "phi", "u", "v", "q", "p")
    assert read.horizontal.A.tolist() == estimate.structure.model().A.tolist()
    told = read.source["identified"]["horizontal"]
    index = estimate.names.index("L_p")
    entry = told["parameters"]["L_p"]
    assert entry["value"] == estimate.values[index]
    assert entry["standard_error"] == pytest.approx(estimate.errors[index])
    assert entry["interval_95"][0] < entry["value"] < entry["interval_95"][1]
    assert "11.2" in told["parameters"]["k"]["fixed"]
    assert told["data"]["sha256"] == data_hash([flight])
    assert set(told["validation_fit_percent"]) == set(judged.outputs)
    assert np.array(told["correlations"]["matrix"]).shape == (18, 18)
    assert design_lq(read, LqWeights()).plant_hash == read.plant_hash


def test_second_axis_keeps_the_first(estimate: Estimate, flight: Record) -> None:
    first = identified_model("one", estimate, [flight], {})
    rng = np.random.default_rng(1)
    data = Record("v", 0.01, VERTICAL.inputs, VERTICAL.outputs, *rng.standard_normal((2, 300, 2)))
    structure = VERTICAL.with_free(["Z_w"])
    vertical = prediction_error(structure, [data])
    both = identified_model("two", vertical, [data], {}, prior=first)
    assert both.horizontal.A.tolist() == first.horizontal.A.tolist()
    assert set(both.source["identified"]) == {"horizontal", "vertical"}
    assert both.source["prior"]["plant_hash"] == first.plant_hash


def test_operating_point_is_the_flown_one() -> None:
    point = operating_point(SOURCE_TRIM, {"B_1s": 0.02, "phi": -0.05, "w": 1.0})
    assert point.B_1s == 0.02 and point.phi == -0.05 and point.theta == SOURCE_TRIM.theta
    assert point.a_1p == pytest.approx(BAR_GAIN * 0.02) and point.b_1p == SOURCE_TRIM.b_1p


def test_blocks() -> None:
    assert [block_of(each) for each in (SERVO_ROTOR, VERTICAL, DRIVE)] == ["horizontal", "vertical", "drive"]
    assert prior_model().vertical.states == ("w", "r", "V_i", "V_t")


def test_description_is_plain(estimate: Estimate, flight: Record) -> None:
    text = json.dumps(described(estimate, [flight], None), allow_nan=False)
    assert '"noise_model": "kalman"' in text and "validation" not in text
    assert number(float("inf")) == "infinite" and number(2.0) == 2.0
