"""`heli identify` on a bag of a known linear flight: coefficients, file, refusals."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from heli_common.flight_state import FlightState, flight_state_values
from heli_common.model_file import ModelFile
from heli_common.rotations import Euler
from heli_common.timing import CONTROL_PERIOD_NS
from heli_common.topics import DATA_TOPICS, TOPICS
from heli_common.vehicle_state import VehicleState, odometry_values
from heli_flight.bag import BagWriter
from heli_flight.cli.main import main
from heli_flight.flight_record import FlightRecord
from heli_flight.flown_signals import flight_signals, free_flight
from heli_identification.helicopter_structures import SERVO_ROTOR
from heli_identification.linear_twin import lq_feedback
from heli_identification.sampling import Hold, sample

TRUTH = SERVO_ROTOR.with_values({"X_u": -1.07, "Y_v": -1.19})
SECONDS, PERIOD = 24.0, 0.01
TRIM = {"theta": -0.01, "phi": -0.09, "B_1s": 0.007, "A_1s": 0.001}


def linear_flight(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """States (N, 8), inputs (N, 2) linear between samples, and the external signal in them (N, 2)."""
    rng, count = np.random.default_rng(seed), round(SECONDS / PERIOD)
    model = sample(TRUTH, TRUTH.values, PERIOD, Hold.LINEAR)
    gain = lq_feedback(TRUTH, PERIOD).D
    r = 0.015 * np.repeat(rng.choice([-1.0, 1.0], size=(count // 8 + 1, 2)), 8, axis=0)[:count]
    x, u = np.zeros((count, 8)), r.copy()
    for step in range(count - 1):
        u[step + 1] += gain @ x[step, :6]
        x[step + 1] = model.A @ x[step] + model.B @ np.concatenate((u[step], u[step + 1]))
        x[step + 1, 2:6] += rng.standard_normal(4) * [0.001, 0.001, 0.003, 0.003]
    return x, u, r


def write_bag(folder: Path, *, excitation: bool = True, still: bool = False) -> Path:
    """A flight of four seconds on the ground and the rest in the air."""
    x, u, r = linear_flight(1)
    rng = np.random.default_rng(2)
    writer = BagWriter(folder, {"plan": "", "seed": "1", "mode": "inprocess", "controller": "lq"})
    for topic in DATA_TOPICS:
        writer.add_topic(topic, TOPICS[topic].layout.ros_type)
    for tick in range(len(x)):
        stamp = tick * CONTROL_PERIOD_NS
        theta, phi, speed_u, speed_v, q, p = x[tick, :6] + rng.standard_normal(6) * 5e-4
        attitude = Euler(0.3, TRIM["theta"] + theta, TRIM["phi"] + phi)
        state = VehicleState((0.0, 0.0, 0.0), attitude, (speed_u, speed_v, 0.0), (p, q, 0.0))
        servo = np.array([TRIM["B_1s"], TRIM["A_1s"], 0.17, 0.2]) + [*u[tick], 0.0, 0.0]
        if still:
            servo[1] = TRIM["A_1s"]
        asked = servo - [*r[tick], 0.0, 0.0]
        stage = FlightState.FLYING if tick * PERIOD >= 4.0 else FlightState.RUN_UP
        values = {
            "odometry": odometry_values(state, [1e-6] * 6, [1e-4] * 6),
            "actuator_state": (*servo, 0.0, *(0.0,) * 10),
            "servo_command": (*asked, *(0.0,) * 8),
            "flight_state": flight_state_values(stage, 163.0),
            "rotor": (0.0, 163.0, 0.0),
            "motor_command": (0.0, 0.0, 5.5),
            "motor_excitation": (0.0, 0.0, 0.01 * (tick % 3)),
        }
        if excitation:
            values["excitation"] = (*r[tick], *(0.0,) * 10)
        for topic, numbers in values.items():
            writer.write(topic, stamp, TOPICS[topic].layout.pack(stamp, [float(n) for n in numbers]))
    writer.close({})
    return folder


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_bag(tmp_path_factory.mktemp("flown") / "flight")


def test_signals_of_a_flight(bag: Path) -> None:
    record = FlightRecord.load(bag)
    signals = flight_signals(record)
    x, u, r = linear_flight(1)
    assert signals.actuators["B_1s"].values == pytest.approx(u[:, 0] + TRIM["B_1s"])
    # what the controllers asked for and the excitation make up the command
    assert signals.commands["A_1s"].values == pytest.approx(u[:, 1] + TRIM["A_1s"])
    assert signals.excitation["B_1s"].values == pytest.approx(r[:, 0])
    assert signals.actuators["U_mot"].values[:4] == pytest.approx([5.5, 5.51, 5.52, 5.5])
    assert signals.excitation["U_mot"].values[:3] == pytest.approx([0.0, 0.01, 0.02])
    assert np.max(np.abs(signals.measured["q"].values - x[:, 4])) < 0.003
    assert np.max(np.abs(signals.measured["phi"].values - TRIM["phi"] - x[:, 1])) < 0.003
    segment = free_flight(record)
    assert segment.begin == pytest.approx(9.0) and segment.end == pytest.approx(SECONDS)


def test_identifies_validates_and_writes(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "flown.yaml"
    words = [
        "identify",
        str(bag),
        "--estimate",
        "4-13",
        "--validate",
        "13.5-23.9",
        "--out",
        str(out),
        "--report",
        str(tmp_path / "report"),
        "--json",
    ]
    assert main(words) == 0
    assert "flight 13.5-23.9" in (tmp_path / "report" / "identification.html").read_text()
    found = json.loads(capsys.readouterr().out)
    true = dict(zip(TRUTH.names, TRUTH.values.tolist(), strict=True))
    for name in ("M_q", "L_p", "M_1", "L_2", "L_b", "Y_v"):
        entry = found["parameters"][name]
        assert abs(entry["value"] - true[name]) < 4.0 * entry["standard_error"] + 0.01 * abs(true[name])
    fits = found["validation_fit_percent"]
    assert fits["q"] > 95.0 and fits["p"] > 95.0 and fits["theta"] > 80.0
    model = ModelFile.read(out)
    assert model.operating_point.phi == pytest.approx(TRIM["phi"], abs=0.01)
    assert model.source["segments"] == ["flight 4-13"] and model.name == "flown"
    assert main(["design", "lq", "--model", str(out), "--out", str(tmp_path / "c.yaml")]) == 0


def test_other_methods_and_words(bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    prior = tmp_path / "prior.yaml"
    assert (
        main(
            ["identify", str(bag), "--method", "ls", "--averaged", "--structure", "full", "--out", str(prior)]
        )
        == 0
    )
    assert "full by ls" in capsys.readouterr().out
    words = ["identify", str(bag), "--free", "M_q", "L_p", "--input", "command", "--noise", "output_error"]
    assert main([*words, "--estimate", "4-12", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    fixed = [name for name, entry in found["parameters"].items() if "fixed" in entry]
    assert len(fixed) == 17 and found["choice"]["input"] == "command"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--estimate", "12"], "'12' is no segment (allowed: A-B in seconds, A before B)"),
        (["--estimate", "12-4"], "'12-4' is no segment"),
        (["--estimate", "90-99"], "segment 90-99 holds no data (allowed: within 0.00-23.99 s)"),
        (["--estimate", "5-6"], "too short for 18 coefficients (allowed: at least 2.0 s)"),
        (["--free", "Z_w"], "no parameter 'Z_w'"),
        (["--fix", "Z_w"], "no parameter 'Z_w'"),
        (["--structure", "vertical", "--estimate", "4-20"], "output w is constant"),
        (["--estimate", "4-13", "--validate", "14-16"], "2.0 s of validation data"),
        (["--prior", "nowhere.yaml"], "cannot be read"),
        (["--averaged", "--estimate", "4-13"], "--noise: kalman on averaged data"),
    ],
)
def test_refusals(
    bag: Path, words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "never.yaml"
    assert main(["identify", str(bag), *words, "--out", str(out)]) == 2
    told = capsys.readouterr().err
    assert message in told and len(told.splitlines()) == 1
    assert not out.exists()


def test_flights_without_excitation(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    still = write_bag(tmp_path / "still", excitation=False, still=True)
    assert main(["identify", str(still), "--estimate", "4-20"]) == 2
    assert "input A_1s is constant" in capsys.readouterr().err
    assert main(["identify", str(tmp_path / "no_such_bag")]) == 2
    capsys.readouterr()
    quiet = write_bag(tmp_path / "quiet", excitation=False)
    assert main(["identify", str(quiet), "--method", "projection", "--estimate", "4-20"]) == 2
    assert "no external signal within the input" in capsys.readouterr().err


def test_written_coefficients_are_readable_by_people(bag: Path, tmp_path: Path) -> None:
    out = tmp_path / "m.yaml"
    assert main(["identify", str(bag), "--free", "M_q", "--estimate", "4-8", "--out", str(out)]) == 0
    told = yaml.safe_load(out.read_text())["source"]["identified"]["horizontal"]
    assert told["parameters"]["M_q"]["unit"] == "1/s" and told["noise_model"] == "kalman"
