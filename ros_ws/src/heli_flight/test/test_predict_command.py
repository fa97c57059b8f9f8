"""`heli predict`: against a small Monte Carlo, growth with time, noise of a model file, refusals."""

import json
from math import log
from pathlib import Path

import numpy as np
import pytest

from heli_common.errors import InputError
from heli_flight.cli.main import main
from heli_flight.cli.predict import durations
from heli_flight.plan import load_plan
from heli_flight.prediction import external_signal, fitting, forecast, noise_of, planned_twin
from heli_identification.excitation_words import excitation_from_text
from heli_identification.helicopter_structures import DRIVE, SERVO_ROTOR
from heli_identification.identified_model import prior_model
from heli_identification.linear_twin import Disturbance
from heli_identification.prediction_error import Search, prediction_error

PRBS = "{signal: prbs, channels: [B_1s, A_1s], amplitude_deg: 0.8, band_rad_s: [0.5, 12], duration: 10.0}"


def test_twelve_flights_scatter_as_predicted() -> None:
    """Estimates of 12 flights of the twin, 10 s each: a scatter of 12 is known to about a fifth."""
    excitation = excitation_from_text(PRBS)
    found = forecast("servo_rotor", excitation, [10.0])
    twin, _ = planned_twin(SERVO_ROTOR, "lq")
    r, search = external_signal(excitation, SERVO_ROTOR), Search(stepwise=False, iterations=15)
    values = [
        prediction_error(SERVO_ROTOR, [twin.fly(r, np.random.default_rng([seed, 3]))], search=search).values
        for seed in range(12)
    ]
    ratios = np.std(values, axis=0, ddof=1) / found.predictions[0].errors
    assert np.sqrt(np.mean(ratios**2)) == pytest.approx(1.0, abs=0.3)
    assert np.sum((ratios > 1.0 / 1.5) & (ratios < 1.5)) >= 15 and np.all((ratios > 0.45) & (ratios < 2.0))


def test_errors_fall_with_the_root_of_time(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["predict", "identification", "--seconds", "60,15", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["seconds"] == [15.0, 60.0] and found["feedback"] == "lq"
    assert found["excitation"]["channels"] == ["B_1s", "A_1s"]
    ratios = [
        entry["standard_errors"][0] / entry["standard_errors"][1] for entry in found["parameters"].values()
    ]
    assert np.median(ratios) == pytest.approx(2.0, rel=0.15)
    entry = found["parameters"]["L_v"]
    wanted = 60.0 * (entry["standard_errors"][1] / (0.1 * 1.802)) ** 2
    assert entry["seconds_for_10_percent"] == pytest.approx(wanted)


def test_the_drive_and_a_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["predict", "drive_chirp", "--structure", "drive", "--seconds", "20"]) == 0
    told = capsys.readouterr().out
    assert "chirp on motor" in told and "k_Omega" in told and "20 s" in told
    chirp = fitting(load_plan("drive_chirp").excitations, "drive")
    assert external_signal(chirp, DRIVE).shape == (6000, 1)


def test_noise_of_an_identified_model() -> None:
    plain = prior_model()
    assert noise_of(plain, SERVO_ROTOR) is None
    states = {f"log_q_{name}": log(4e-6) for name in ("u", "v", "q", "p")}
    noise = states | {f"log_r_{name}": log(1e-4) for name in SERVO_ROTOR.outputs}
    plain.source["identified"] = {"horizontal": {"noise": noise}}
    found = noise_of(plain, SERVO_ROTOR)
    assert isinstance(found, Disturbance)
    assert found.process == pytest.approx([0.0, 0.0, 2e-3, 2e-3, 2e-3, 2e-3, 0.0, 0.0])
    assert found.measurement == pytest.approx(np.full(6, 1e-2))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "one excitation is needed (allowed: a plan, or --signal)"),
        (["identification", "--signal", PRBS], "one excitation is needed"),
        (["hover"], "nothing excites A_1s, B_1s alone"),
        (["nowhere"], "unknown"),
        (["--signal", PRBS, "--structure", "vertical"], "B_1s, A_1s excited (allowed: channels of vertical"),
        (["--signal", "{signal: prbs}"], "channel"),
        (["identification", "--seconds", "15,x"], "'x' is no duration (allowed: 5-600 s"),
        (["identification", "--model", "nowhere.yaml"], "cannot be read"),
        (["identification", "--controller", "nowhere"], "nowhere"),
    ],
)
def test_refusals(words: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["predict", *words]) == 2
    told = capsys.readouterr().err
    assert message in told and len(told.splitlines()) == 1


def test_durations() -> None:
    assert durations("15, 30") == [15.0, 30.0]
    with pytest.raises(InputError, match="'2' is no duration"):
        durations("2")


def test_a_model_without_the_block(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "m.yaml"
    prior_model().write(path)
    assert main(["predict", "drive_chirp", "--structure", "drive", "--model", str(path)]) == 2
    assert "prior has no drive block" in capsys.readouterr().err
