"""The set-up of the shell scripts, with a stand-in for Python that installs nothing but notes its calls."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from heli_flight.process_table import PROCESSES

ROOT = Path(__file__).resolve().parents[1]

STAND_IN = r"""#!/usr/bin/env bash
# A Python that can make a venv of itself; CALLS gets one line per call, FAIL breaks the call it names.
case "$*" in
    "-c "*sys.version_info*) echo "${VERSION-3.11}" && exit ;;
    "-c import ensurepip"*) exit "${NO_VENV:-0}" ;;
    "-c "*) exit ;;
    -V) echo "Python 3.11.0" && exit ;;
esac
echo "$*" >>"$CALLS"
[[ -z ${FAIL:-} || $* != *"$FAIL"* ]] || exit 5
case "$*" in
    "-m venv -- "*)
        mkdir -p "$4/bin" && cp "$0" "$4/bin/python" && ln -sf python "$4/bin/heli"
        echo "version = 3.11.0" >"$4/pyvenv.cfg"
        ;;
    *"-r requirements"*) sleep "${SLOW:-0}" ;;
    *_node*) env >"$CALLS.env" ;;
esac
"""


class Bench:
    """A copy of what the scripts touch, in a folder with a space in its name."""

    def __init__(self, folder: Path) -> None:
        self.root = folder / "my bench"
        self.calls_file = folder / "calls"
        self.python = folder / "stand_in"
        self.python.write_text(STAND_IN)
        self.python.chmod(0o755)
        shutil.copytree(ROOT / "ros_ws/scripts", self.root / "ros_ws/scripts")
        for name in ("requirements.txt", "requirements-dev.txt"):
            shutil.copy(ROOT / name, self.root)
        (self.root / "tests").mkdir()
        shutil.copy(ROOT / "tests/run.sh", self.root / "tests")
        for setup in (*ROOT.glob("heli_*/setup.py"), *ROOT.glob("ros_ws/src/heli_[cf]*/setup.py")):
            package = self.root / setup.parent.relative_to(ROOT)
            if not package.exists():
                (package / package.name).mkdir(parents=True)
                (package / package.name / "__init__.py").touch()
                shutil.copy(setup, package)
        self.environment = {
            **{name: value for name, value in os.environ.items() if not name.startswith(("HELI_", "PIP_"))},
            "HELI_PYTHON": str(self.python),
            "HELI_CACHE": str(folder / "cache"),
            "CALLS": str(self.calls_file),
        }

    def start(self, script: str, *arguments: str, **environment: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [self.root / "ros_ws/scripts" / script, *arguments],
            cwd=self.root.parent,
            env=self.environment | environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def run(self, script: str, *arguments: str, code: int = 0, **environment: str) -> str:
        """Run a script to its end, expect its exit code, return what it said."""
        process = self.start(script, *arguments, **environment)
        output, errors = process.communicate(timeout=60)
        assert process.returncode == code, output + errors
        return errors

    def calls(self) -> list[str]:
        """The calls since the last look."""
        lines = self.calls_file.read_text().splitlines() if self.calls_file.exists() else []
        self.calls_file.unlink(missing_ok=True)
        return lines


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    return Bench(tmp_path)


COMPILE = "-m heli_flight.warm_up"


def test_set_up_makes_installs_compiles_and_then_rests(bench: Bench) -> None:
    said = bench.run("setup.sh")
    make, first, pinned, ours, bytecode, compile_ = bench.calls()
    assert make == f"-m venv -- {bench.root}/.venv"
    assert "--require-hashes" in first and first.endswith("-r /dev/stdin")
    assert "--require-hashes" in pinned and pinned.endswith("-r requirements.txt")
    assert (
        "--no-deps --no-compile --no-build-isolation --use-pep517" in ours
        and ours.count("--editable=./") == 6
    )
    assert bytecode.startswith("-m compileall") and compile_ == COMPILE
    assert "complete" in said.splitlines()[-1]
    assert bench.run("setup.sh") == ""
    assert bench.calls() == []


def test_the_tools_of_ros_find_packages_and_executables(bench: Bench) -> None:
    bench.run("setup.sh")
    venv = bench.root / ".venv"
    packages = {path.name for path in (venv / "share/ament_index/resource_index/packages").iterdir()}
    assert packages == {path.name for path in (ROOT / "ros_ws/src").iterdir()}
    for name in packages:
        assert (venv / "share" / name / "package.xml").readlink().parent.name == name
    executables = {path.name for path in (venv / "lib").glob("heli_*/*")}
    assert executables == {process.executable for process in PROCESSES} | {"heli", "replay_node"}


def test_set_up_for_tests_serves_flights(bench: Bench) -> None:
    bench.run("setup.sh")
    bench.calls()
    bench.run("setup.sh", "--dev")
    assert any(call.endswith("-r requirements-dev.txt") for call in bench.calls())
    bench.run("setup.sh")
    bench.run("setup.sh", "--dev")
    assert bench.calls() == []


@pytest.mark.parametrize("broken", ["-m venv", "-r /dev/stdin", "-r requirements.txt", "--editable"])
def test_broken_set_up_is_done_afresh(bench: Bench, broken: str) -> None:
    bench.run("setup.sh", code=5, FAIL=broken)
    (bench.root / ".venv/half_installed").touch()
    bench.calls()
    bench.run("setup.sh")
    assert len(bench.calls()) == 6
    assert not (bench.root / ".venv/half_installed").exists()


def test_failed_compilation_alone_is_repeated(bench: Bench) -> None:
    bench.run("setup.sh", code=5, FAIL=COMPILE)
    bench.calls()
    bench.run("setup.sh")
    assert bench.calls() == [COMPILE]


def test_compiling_may_be_left_for_later(bench: Bench) -> None:
    bench.run("setup.sh", "--dev", "--no-kernels")
    assert COMPILE not in bench.calls()
    bench.run("setup.sh", "--no-kernels")
    assert bench.calls() == []
    bench.run("setup.sh", "--dev")
    assert bench.calls() == [COMPILE]
    bench.run("setup.sh")
    assert bench.calls() == []


PACKAGES = ("heli_bench_sim", "heli_navigation", "heli_control", "heli_identification")
IN_WORKSPACE = ("ros_ws/src/heli_common", "ros_ws/src/heli_flight")


@pytest.mark.parametrize("broken", ["", "pytest heli_navigation", "-m alone", "check", COMPILE])
def test_the_test_run_runs_every_check_and_names_one_that_failed(bench: Bench, broken: str) -> None:
    for name in ("ways_of_running", "side_by_side", "live_graph", "refusals", "safety"):
        (bench.root / f"tests/test_{name}.py").touch()
    bench.run("setup.sh", "--dev", "--no-kernels")
    for name in ("ruff", "mypy"):
        (bench.root / ".venv/bin" / name).symlink_to("python")
    bench.calls()
    process = bench.start("../../tests/run.sh", FAIL=broken)
    output, _ = process.communicate(timeout=60)
    calls = bench.calls()
    assert process.returncode == (1 if broken else 0)
    assert output.splitlines()[-1].startswith("failed: ") is bool(broken)
    words = " ".join(call for call in calls if call.startswith("-m pytest")).split()
    assert all(words.count(package) == 1 for package in (*PACKAGES, *IN_WORKSPACE))
    apart = [word.removeprefix("--ignore=") for word in words if word.startswith("--ignore=")]
    assert words.count("tests") == 2 and apart and all(words.count(path) == 1 for path in apart)
    assert {"check", "format --check", COMPILE} <= set(calls)
    assert any(call.startswith("-pheli_common") for call in calls)


def test_edits_lead_to_what_they_concern(bench: Bench) -> None:
    bench.run("setup.sh")
    bench.calls()
    (bench.root / "heli_control/heli_control/attitude.py").write_text("GAIN = 2.0\n")
    bench.run("setup.sh")
    assert bench.calls() == [COMPILE]
    (bench.root / "heli_control/setup.py").write_text("changed")
    bench.run("setup.sh")
    assert [call for call in bench.calls() if call.startswith("-m venv")] == []
    (bench.root / "requirements.txt").write_text("setuptools==1\n")
    bench.run("setup.sh")
    assert any(call.endswith("-r requirements.txt") for call in bench.calls())
    (bench.root / ".venv/bin/python").unlink()
    bench.run("setup.sh")
    assert bench.calls()[0].startswith("-m venv")


def test_two_set_ups_at_a_time_do_the_work_once(bench: Bench) -> None:
    both = [bench.start("setup.sh", SLOW="0.5") for _ in range(2)]
    said = [process.communicate(timeout=60)[1] for process in both]
    assert [process.returncode for process in both] == [0, 0]
    assert sum("waiting for another set-up" in errors for errors in said) == 1
    assert len(bench.calls()) == 6


@pytest.mark.parametrize(
    ("environment", "reason"),
    [
        ({"HELI_PYTHON": "/nonexistent"}, "needs CPython 3.10 to 3.13"),
        ({"VERSION": ""}, "needs CPython 3.10 to 3.13"),
        ({"NO_VENV": "1"}, "apt install python3.11-venv"),
        ({"HELI_VENV": "ros_ws"}, "folder with other things"),
    ],
)
def test_unusable_machine_is_refused_in_one_line(
    bench: Bench, environment: dict[str, str], reason: str
) -> None:
    (bench.root.parent / "ros_ws").mkdir()
    (bench.root.parent / "ros_ws/file").touch()
    (line,) = bench.run("navigation.sh", code=2, **environment).splitlines()
    assert reason in line
    assert bench.calls() == []


def test_unknown_argument_is_refused(bench: Bench) -> None:
    assert "--deb" in bench.run("setup.sh", "--deb", code=2)


def test_node_starts_clean_of_another_ros(bench: Bench) -> None:
    other = {
        "PYTHONPATH": "/opt/ros/jazzy/lib/python3.12/site-packages",
        "AMENT_PREFIX_PATH": "/opt/ros/jazzy",
        "LD_LIBRARY_PATH": "/opt/ros/jazzy/lib",
        "_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1",
        "RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp",
    }
    bench.run("navigation.sh", "--ros-args", "-p", "text:=two words", HELI_VENV="my venv", **other)
    assert bench.calls()[-1] == "-m heli_navigation.nodes.navigation_node --ros-args -p text:=two words"
    seen = dict(
        line.split("=", 1) for line in Path(f"{bench.calls_file}.env").read_text().splitlines() if "=" in line
    )
    assert not {"PYTHONPATH", "LD_LIBRARY_PATH", "_ROS_WHEELS_BOOTSTRAP_COMPLETE"} & seen.keys()
    assert seen["RMW_IMPLEMENTATION"] == "rmw_fastrtps_cpp"
    assert seen["ROS_AUTOMATIC_DISCOVERY_RANGE"] == os.environ.get(
        "ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"
    )
    assert seen["PATH"].startswith(f"{bench.root.parent}/my venv/bin:")


@pytest.mark.parametrize(
    ("arguments", "call"),
    [((), "fly hover_steps"), (("identification", "--seed", "3"), "fly identification --seed 3")],
)
def test_fly_flies_hover_steps_unless_told(bench: Bench, arguments: tuple[str, ...], call: str) -> None:
    bench.run("fly.sh", *arguments)
    assert bench.calls()[-1] == call


def test_scripts_run_through_links(bench: Bench) -> None:
    link = bench.root.parent / "supervise"
    link.symlink_to(bench.root / "ros_ws/scripts/supervisor.sh")
    subprocess.run([link], env=bench.environment, check=True, capture_output=True, timeout=60)
    assert bench.calls()[-1] == "-m heli_flight.nodes.supervisor_node"
