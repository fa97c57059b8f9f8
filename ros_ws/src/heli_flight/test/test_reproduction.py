"""The reproduction from made-up outcomes: verdicts by hand, statistics, files kept, page, refusals."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from heli_common.linear_model import StateSpace
from heli_control.controller_file import ControllerAxis, load_controller
from heli_flight import reproduction_figures as figures
from heli_flight.cli.main import main
from heli_flight.gust_stiffness import stiffness
from heli_flight.linear_flight import fly_linear
from heli_flight.published_flights import CONTROLLERS, HOVER
from heli_flight.reproduction_claims import compared
from heli_flight.reproduction_flights import Job, Outcome, _plateau
from heli_flight.reproduction_hover_tables import hover_table, order_table
from heli_flight.reproduction_report import write_reproduction
from heli_flight.reproduction_results import Outcomes, shown
from heli_flight.reproduction_run import COMPLETE, QUICK, jobs
from heli_flight.reproduction_statistics import Interval, interval, order, paired_ratio, rank_correlation
from heli_flight.reproduction_store import load, save

NAMES = ("sigma_x_m", "sigma_y_m", "sigma_z_m", "sigma_psi_rad")
REST = {
    "max_xy_m": 0.03, "max_z_m": 0.2, "sigma_theta_rad": 0.01, "sigma_phi_rad": 0.01,
    "mean_theta_rad": math.radians(0.8), "mean_phi_rad": math.radians(-2.4), "mean_B_1s_rad": 0.0,
    "mean_A_1s_rad": 0.0, "mean_theta_0_rad": math.radians(7.2), "mean_theta_t_rad": math.radians(12.4),
}  # fmt: skip


def curves(names: tuple[str, ...]) -> dict[str, np.ndarray]:
    """A few samples of everything that is drawn."""
    time = np.linspace(0.0, 8.0, 41)
    return {"time": time} | {name: 0.01 * np.sin(time + i) for i, name in enumerate(names)}


def hovers(scale: dict[str, float]) -> dict[Job, Outcome]:
    """Three seeds; each controller's sigmas are the printed ones of LQ times its scale."""
    found = {}
    for name in CONTROLLERS:
        for seed, wider in ((1, 0.9), (2, 1.0), (3, 1.1)):
            sigmas = [wider * scale[name] * value for value in HOVER["lq"]]
            figures = dict(zip(NAMES, sigmas, strict=True)) | REST
            drawn = curves(("x", "y", "z", "x_ref", "y_ref", "z_ref", "theta", "phi")) if seed == 1 else {}
            found[Job("F2", name, seed, seed == 1)] = Outcome("", figures, drawn)
    return found


def step(axis: str, rise: float) -> dict[str, object]:
    return {
        "axis": axis, "rise_time_s": rise, "overshoot_percent": 3.0, "settling_time_s": None,
        "final_error_m": 0.0,
        "cross_x_max_m": 0.01, "cross_y_max_m": 0.01, "theta_range_rad": 0.1, "phi_range_rad": 0.1,
        "late_theta_rad": 0.001, "late_phi_rad": 0.001, "rms_q_rad_s": 0.1, "rms_p_rad_s": 0.1,
    }  # fmt: skip


def everything() -> Outcomes:
    """One or a few outcomes of every experiment."""
    found = hovers(dict(zip(CONTROLLERS, (1.0, 0.9, 0.8, 0.3, 0.4), strict=True)))
    moving = curves(
        ("x", "y", "z", "x_ref", "y_ref", "theta", "phi", "u", "v", "fan", "B_1s", "noise",
         *(f"linear_{name}" for name in ("x", "y", "theta", "phi", "u", "v")))
    )  # fmt: skip
    plateau = {f"{kind}_{name}": 0.01 for kind in ("mean", "sigma") for name in ("x", "theta", "q")}
    for place, name in enumerate(CONTROLLERS):
        steps = [step(axis, 1.0 + 0.1 * place) for axis in ("x", "y")]
        found[Job("F1", name, 1, True)] = Outcome("", {"steps": steps}, moving)
        plateaus = [{"asked": float(v), "fan": float(v)} | plateau for v in range(5)]
        found[Job("F3", name, 1, True)] = Outcome("tilt", {"plateaus": plateaus, "lost_at": 4.6}, moving)
        for kind in ("F4", "F4b"):
            level = {
                "borne": 0.017,
                "lost": None if name == "gst" else 0.019,
                "level": 0.018,
                "reason": "tilt",
            }
            found[Job(kind, name, 1)] = Outcome("", level)
        found[Job("F4n", name, 1, True)] = Outcome("", {"sigma": 0.0175}, moving)
        found[Job("F7", name, 1, True)] = Outcome(
            "", {"apart": dict.fromkeys(("x", "y", "u", "v", "theta", "phi"), 0.01)}, moving
        )
        link = {"dead_time": 0.1, "after": 1.5, "delay_margin": 0.06}
        found[Job("F8", name, 1, True)] = Outcome("tilt of 21 deg", link)
    found[Job("F5", "lq", 1)] = Outcome(
        "",
        {
            "flown": 6, "planned": 6, "remark": "",
            "horizontal": {"fit": {"u": 86.0}, "values": {"X_u": -1.2}, "errors": {"X_u": 0.05}},
        },
    )  # fmt: skip
    return found


def test_intervals_by_hand() -> None:
    found = interval([1.0, 2.0, 3.0])
    assert found is not None
    half = 4.302653 / math.sqrt(3.0)  # Student, 2 degrees of freedom, standard deviation 1
    assert (found.mean, found.low, found.high) == pytest.approx((2.0, 2.0 - half, 2.0 + half), rel=1e-6)
    assert interval([]) is None and math.isnan((interval([1.0]) or found).low)
    ratio = paired_ratio({1: 2.0, 2: 8.0, 9: 1.0}, {1: 1.0, 2: 2.0})
    assert ratio is not None and ratio.mean == pytest.approx(math.sqrt(8.0)) and ratio.count == 2
    assert order({"a": 2.0, "b": 1.0}) == ("b", "a")
    assert rank_correlation({"a": 1.0, "b": 2.0, "c": 3.0}, {"a": 3.0, "b": 2.0, "c": 1.0}) == pytest.approx(
        -1.0
    )
    assert shown(Interval(-1.0, -2.0, 0.5, 3), 1, "cm") == "−1.0 [−2.0, 0.5] cm"


def test_verdicts_by_hand() -> None:
    scale = dict(zip(CONTROLLERS, (1.2, 1.2 * 0.93, 1.2, 1.2, 1.2), strict=True))
    rows = {row.what: row for row in compared(hovers(scale))}
    lq = rows["LQ: sigma x (calibrated)"]
    assert lq.holds and lq.ratio == pytest.approx(1.2)
    gst = rows["GS/T 1DOF: sigma x, over that of LQ"]
    assert gst.holds and gst.ratio == pytest.approx(0.93 * 4.61 / 4.30)
    ncf = rows["loop shaping 1DOF: sigma x, over that of LQ"]
    assert ncf.holds is False and ncf.ratio == pytest.approx(4.61 / 0.96)
    theta = rows["operating point: theta"]
    assert theta.holds and theta.ratio == pytest.approx(0.8 / 0.798)
    table = hover_table(hovers(scale))
    assert len(table.rows) == 20 and table.rows[0][3].text.startswith("5.53")
    assert (
        order_table(hovers(dict(zip(CONTROLLERS, (5, 4, 3, 1, 2), strict=True))))
        .rows[0][2]
        .text.startswith("ncf < ncf2")
    )


def test_every_figure_of_the_source_is_drawn() -> None:
    found = everything()
    graphs = [
        *figures.step_graphs(found), *figures.hover_graphs(found), *figures.wind_graphs(found),
        *figures.noise_graphs(found), *figures.linear_graphs(found),
    ]  # fmt: skip
    titles = " ".join(graph.title for graph in graphs)
    printed = [f"3.{number}" for number in range(27, 39)] + [f"5.{number}" for number in range(5, 15)]
    assert all(f"Figure {figure}:" in titles for figure in printed)
    assert len({graph.key for graph in graphs}) == len(graphs)
    assert len(figures.linear_graphs(found)) == 2 * len(CONTROLLERS)


def test_page_and_numbers_from_made_up_outcomes(tmp_path: Path) -> None:
    # curves of two jobs are enough for the page: each graph takes plotly a while
    drawn = {("F1", "lq"), ("F1", "gst"), ("F4n", "lq")}
    found = {
        job: one if (job.experiment, job.controller) in drawn else Outcome(one.lost, one.figures)
        for job, one in everything().items()
        if (job.experiment, job.controller) != ("F7", "lq")
    }
    written = write_reproduction(found, tmp_path, {"command": "none"})
    page = written.page.read_text()
    for word in ("Figure 3.27", "Figure 5.13", "Table 5.2", "Wind from the front", "Wireless", "none</dd>"):
        assert word in page, word
    assert "src=" not in page.split("<script>")[0] and '<link rel="stylesheet' not in page
    numbers = json.loads(written.numbers.read_text())
    assert len(numbers["flights"]) == len(found)
    assert len(numbers["comparison"]) == len(written.rows) > 40
    lost = [row for row in written.rows if row.experiment == "F8"]
    assert len(lost) == 5 and all(row.holds for row in lost)


def test_outcomes_are_kept_and_known_by_their_hash(tmp_path: Path) -> None:
    outcome = Outcome("tilt", {"a": 1.5, "list": [{"x": None}]}, {"time": np.array([0.0, 0.5])})
    path = tmp_path / "one.npz"
    save(path, outcome, "abc")
    back = load(path, "abc")
    assert back is not None and (back.lost, back.figures) == (outcome.lost, outcome.figures)
    assert back.curves["time"].tolist() == [0.0, 0.5]
    assert load(path, "other") is None and load(tmp_path / "none.npz", "abc") is None
    path.write_bytes(path.read_bytes()[:40])
    assert load(path, "abc") is None


def test_jobs() -> None:
    complete = jobs(COMPLETE)
    assert len({job.key for job in complete}) == len(complete)
    assert sum(job.experiment == "F2" for job in complete) == 100
    assert {job.experiment for job in jobs(QUICK)} == {job.experiment for job in complete}


def test_plateau_is_the_end_of_the_first_stretch() -> None:
    fan = np.concatenate((np.zeros(500), np.linspace(0.0, 1.0, 100), np.ones(1200), np.zeros(900)))
    found = _plateau(fan, 1.0, 0, len(fan))
    assert (found[0], found[-1]) == (1800 - 850, 1799)
    assert len(_plateau(fan, 0.0, 0, len(fan))) == 0  # the first stretch is too short
    assert len(_plateau(fan, 2.0, 0, len(fan))) == 0


def test_linear_plant_follows_a_step() -> None:
    reference = np.zeros((1200, 2))
    reference[100:, 0] = 0.3
    flown = fly_linear(load_controller("gst2"), reference, np.zeros_like(reference))
    x, y = flown.column("x"), flown.column("y")
    assert np.all(x[:100] == 0.0)
    assert x[-1] == pytest.approx(0.3, abs=0.03) and np.max(np.abs(y)) < 0.03
    speed = np.gradient(x, flown.time)
    assert np.corrcoef(speed[100:], flown.column("u")[100:])[0, 1] > 0.999
    with pytest.raises(ValueError, match="shapes"):
        fly_linear(load_controller("lq"), reference, np.zeros((3, 2)))


@pytest.mark.parametrize(
    ("words", "said"),
    [(["--only", "F9"], "no experiment"), (["--workers", "0"], "--workers"), (["--seeds", "0"], "--seeds")],
)
def test_refusals(words: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["reproduce", "--out", str(tmp_path / "out"), *words]) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_file_is_no_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "out").write_text("")
    assert main(["reproduce", "--out", str(tmp_path / "out")]) == 2
    assert "no folder" in capsys.readouterr().err


def test_stiffness_by_hand() -> None:
    """A law without memory: tilt per velocity error is the ratio of its gains; collectives act themselves."""
    lq = load_controller("lq")

    def still(axis: ControllerAxis, gains: dict[tuple[str, str], float]) -> ControllerAxis:
        d = np.zeros(axis.system.D.shape)
        for (command, measured), gain in gains.items():
            d[axis.system.outputs.index(command), axis.system.inputs.index(measured)] = gain
        none = np.zeros((0, 0))
        b, c = np.zeros((0, d.shape[1])), np.zeros((d.shape[0], 0))
        system = StateSpace((), axis.system.inputs, axis.system.outputs, none, b, c, d)
        return ControllerAxis(system, np.zeros((0, d.shape[0])))

    plane = {("B_1s", "u"): 0.2, ("B_1s", "theta"): -1.0, ("A_1s", "v"): -0.3, ("A_1s", "phi"): -0.6}
    rest = {("theta_0", "w"): 0.05, ("theta_t", "r"): -0.1}
    own = replace(lq, horizontal=still(lq.horizontal, plane), vertical=still(lq.vertical, rest))
    assert stiffness(own, 0.67) == pytest.approx((0.2, 0.5, 0.05, 0.1))
    assert stiffness(lq, 0.67)[3] == pytest.approx(0.094, abs=0.001)
