"""Campaigns: one result whatever flies it, resumed after a kill, and a worst flight that flies again."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from heli_common.errors import InputError
from heli_control.controller_file import load_controller
from heli_control.motor_controller_file import load_motor_controller
from heli_flight import campaign as engine
from heli_flight.campaign import JOURNAL, Journal, run_campaign
from heli_flight.campaign_flight import Campaign
from heli_flight.campaign_results import parquet, summary, wilson, worst, write_results
from heli_flight.cli.main import main
from heli_flight.plan import load_plan
from heli_flight.vary_file import parse_vary

VARY = """
controller: {choice: [lq, ncf2]}
wind_m_s: {uniform: [0.0, 2.0]}
parameters: {bench_sim: {helicopter.mass: {normal: [1.0, 0.03], times_default: true}}}
"""
FLIGHTS = 4


def campaign_of(text: str = VARY) -> Campaign:
    vary = parse_vary(text)
    controllers = {name: load_controller(name) for name in ("lq", "ncf2")}
    return Campaign(load_plan("campaign_hover"), vary, controllers, load_motor_controller("motor"))


def silent(_done: int, _total: int) -> None:
    pass


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign of four flights in this process."""
    folder = tmp_path_factory.mktemp("campaign") / "one"
    campaign = campaign_of()
    journal = Journal(folder, campaign)
    journal.add(engine.fly_chunk(campaign, range(FLIGHTS)))
    journal.close()
    write_results(folder, run_campaign(campaign, FLIGHTS, folder, silent), campaign)
    return folder


def test_wilson_by_hand_and_as_the_score_equation_has_it() -> None:
    half = wilson(5, 10)  # z^2 = 3.8415: 0.5 +- 1.96 sqrt(0.025 + 0.0096) / 1.384
    assert (half.low, half.high) == pytest.approx((0.2366, 0.7634), abs=1e-4)
    assert wilson(0, 10).low == 0.0 and wilson(10, 10).high == 1.0
    some = wilson(17, 60)

    def score(p: float) -> float:
        return (17 / 60 - p) ** 2 - 1.959963984540054**2 * p * (1 - p) / 60

    assert some.low == pytest.approx(brentq(score, 1e-6, 17 / 60), abs=1e-9)
    assert some.high == pytest.approx(brentq(score, 17 / 60, 1.0 - 1e-6), abs=1e-9)
    with pytest.raises(ValueError, match="3 successes of 2"):
        wilson(3, 2)


def test_rows_say_what_was_drawn_and_how_it_went(flown: Path) -> None:
    lines = [json.loads(line) for line in (flown / JOURNAL).read_text().splitlines()[1:]]
    assert [line["flight"] for line in lines] == list(range(FLIGHTS))
    for line in lines:
        assert line["controller"] in ("lq", "ncf2") and 0.0 <= line["wind_m_s"] <= 2.0
        assert 0.001 < line["sigma_x_m"] < 0.2 or line["reason"]
        assert 15.0 < line["duration_s"] < 35.0 and len(line["trace"]) == 64


def test_a_table_that_pyarrow_reads_back(flown: Path) -> None:
    from pyarrow import parquet as pq

    table = pq.read_table(flown / "flights.parquet")
    assert table.num_rows == FLIGHTS
    assert table.column("flight").to_pylist() == list(range(FLIGHTS))
    assert b"campaign_hover" in table.schema.metadata[b"plan"]
    again = campaign_of()
    rows = run_campaign(again, FLIGHTS, flown, silent)
    assert parquet(rows, again) == (flown / "flights.parquet").read_bytes()


def test_resumed_after_a_cut_line_by_two_processes_it_gives_the_same_file(
    flown: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "two"
    folder.mkdir()
    lines = (flown / JOURNAL).read_text().splitlines(keepends=True)
    # two flights are there, in another order, and half of a line
    (folder / JOURNAL).write_text("".join([lines[0], lines[3], lines[1], lines[2][:40]]))
    campaign, told = campaign_of(), []
    rows = run_campaign(campaign, FLIGHTS, folder, lambda *now: told.append(now), workers=2)
    assert told[0] == (2, FLIGHTS) and told[-1] == (FLIGHTS, FLIGHTS)
    write_results(folder, rows, campaign)
    assert (folder / "flights.parquet").read_bytes() == (flown / "flights.parquet").read_bytes()


def test_a_dask_cluster_of_two_workers_gives_the_same_file(flown: Path, tmp_path: Path) -> None:
    from distributed import LocalCluster

    campaign, folder = campaign_of(), tmp_path / "cluster"
    with LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        processes=False,
        protocol="tcp://",
        host="127.0.0.1",
        dashboard_address=None,
    ) as cluster:
        rows = run_campaign(campaign, FLIGHTS, folder, silent, dask=cluster.scheduler_address)
    write_results(folder, rows, campaign)
    assert (folder / "flights.parquet").read_bytes() == (flown / "flights.parquet").read_bytes()


def test_a_scheduler_that_is_not_there_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine, "PATIENCE", "0.5s")
    with pytest.raises(InputError, match=r"--dask: 'nowhere:1'"):
        run_campaign(campaign_of(), FLIGHTS, tmp_path / "none", silent, dask="nowhere:1")
    assert not (tmp_path / "none").exists()


def test_another_campaign_and_a_used_folder_are_refused(flown: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds another campaign"):
        run_campaign(campaign_of(VARY + "seed: 2\n"), FLIGHTS, flown, silent)
    (tmp_path / "letter.txt").write_text("dear")
    with pytest.raises(InputError, match="is not empty"):
        run_campaign(campaign_of(), FLIGHTS, tmp_path, silent)


def test_the_worst_flight_flies_again_bit_by_bit(
    flown: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = flown / "worst"
    files = ["--params-file", f"{folder}/parameters.yaml", "--motor", f"{folder}/motor.yaml"]
    where = ["--out", str(tmp_path), "--name", "again", "--no-report", "--mode", "inprocess"]
    main(["fly", f"{folder}/plan.yaml", *files, *where, "--json"])
    capsys.readouterr()
    ask = ["campaign", "campaign_hover", "--flights", "1", "--out", str(flown), "--check"]
    assert main([*ask, str(tmp_path / "again")]) == 0
    assert "the same bits" in capsys.readouterr().out
    row = json.loads((folder / "flight.json").read_text())
    (folder / "flight.json").write_text(json.dumps(row | {"trace": "0" * 64}))
    assert main([*ask, str(tmp_path / "again")]) == 3
    (folder / "flight.json").write_text(json.dumps(row))


def test_worst_is_the_earliest_loss_then_the_largest_error() -> None:
    def row(number: int, error: float, reason: str = "", duration: float = 20.0) -> dict[str, object]:
        flown = not reason
        return {
            "flight": number,
            "flown": flown,
            "success": flown,
            "reason": reason,
            "duration_s": duration,
            "max_position_m": error,
        }

    calm = [row(0, 0.1), row(1, 0.3), row(2, 0.3)]
    assert worst(calm)["flight"] == 1
    lost = [*calm, row(3, math.nan, "tilt", 15.0), row(4, 0.4, "tilt", 12.0)]
    assert worst(lost)["flight"] == 4


def test_faults_are_flown_by_the_components() -> None:
    campaign = campaign_of("faults: [{kind: imu_dropout, at_s: 12.0, for_s: 0.1}]")
    row = campaign.fly(0)
    assert row["faults"] == "imu_dropout" and row["flown"]
    calm = campaign_of("seed: 1").fly(0)
    assert calm["seed"] == row["seed"] and calm["trace"] != row["trace"]


def test_a_figure_is_that_of_the_report(flown: Path, tmp_path: Path) -> None:
    """The same hover from the bag, by `flight_metrics`."""
    from heli_flight.flight_record import FlightRecord
    from heli_flight.fly_in_process import fly_in_process
    from heli_flight.metrics import flight_metrics
    from heli_flight.mode import Mode
    from heli_flight.order import FlightOrder

    campaign = campaign_of("seed: 1")
    row, plan = campaign.fly(0), campaign.drawn(0).plan
    order = FlightOrder(
        plan=plan,
        plan_name="campaign_hover",
        mode=Mode.INPROCESS,
        seed=plan.seed,
        controller=campaign.controllers["lq"],
        controller_name="lq",
        bag=tmp_path / "bag",
    )
    fly_in_process(order, lambda _: None)
    hovers = flight_metrics(FlightRecord.load(order.bag))["hover"]
    lengths = np.array([hover["duration_s"] for hover in hovers])
    variance = np.array([hover["sigma_z_m"] ** 2 for hover in hovers])
    assert row["sigma_z_m"] == pytest.approx(math.sqrt(float(lengths @ variance / lengths.sum())), rel=1e-9)


def test_summary_counts_why_flights_were_lost(flown: Path) -> None:
    campaign = campaign_of()
    rows = [dict(row) for row in run_campaign(campaign, FLIGHTS, flown, silent)]
    lost = {"flown": False, "success": False}
    rows[0] |= lost | {"reason": "height -0.15 m not reached after 13.2 s at 23.01 s"}
    rows[1] |= lost | {"reason": "height -0.15 m not reached after 13.2 s at 24.97 s"}
    found = summary(rows, campaign)
    assert found["losses"] == {"height .. m not reached after .. s": 2}
    assert sum(part["success"]["flights"] for part in found["controllers"].values()) == FLIGHTS


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--flights", "0"], "--flights: 0 (allowed: 1"),
        (["--flights", "4", "--workers", "0"], "--workers: 0 (allowed: 1"),
        (["--flights", "4", "--controller", "nobody"], "nobody"),
        (["--flights", "4", "--vary", "missing.yaml"], "missing.yaml: cannot be read"),
        (["--flights", "3", "--vary", "GRID"], "--flights: 3 (allowed: a multiple of 2"),
    ],
)
def test_bad_options_end_in_one_line(
    words: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    grid = tmp_path / "grid.yaml"
    grid.write_text("grid: {wind_m_s: [0.0, 1.0]}")
    words = [str(grid) if word == "GRID" else word for word in words]
    assert main(["campaign", "campaign_hover", "--out", str(tmp_path / "out"), *words]) == 2
    shown = capsys.readouterr().err
    assert said in shown and shown.count("\n") == 1
    assert not (tmp_path / "out").exists()
