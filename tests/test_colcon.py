"""colcon finds and builds the six packages (in a folder of its own)."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

WORKSPACE = Path(__file__).resolve().parents[1] / "ros_ws"
COMMANDS = {
    "heli_bench_sim": {"bench_sim_node"},
    "heli_common": set(),
    "heli_control": {"attitude_controller_node", "motor_controller_node", "position_controller_node"},
    "heli_flight": {"heli", "recorder_node", "replay_node", "supervisor_node"},
    "heli_identification": {"identification_node"},
    "heli_navigation": {"navigation_node"},
}


def colcon(folder: Path, *arguments: str | Path) -> str:
    """Run colcon of this environment on the workspace; its logs go to the folder."""
    program = [sys.executable, "-m", "colcon", "--log-base", folder / "log", *arguments]
    done = subprocess.run(
        [*program, "--base-paths", WORKSPACE / "src"],
        cwd=folder,
        env={**os.environ, "COLCON_HOME": str(folder)},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_colcon_lists_six_ament_python_packages(tmp_path: Path) -> None:
    lines = [line.split("\t") for line in colcon(tmp_path, "list").splitlines()]
    assert {name: kind for name, _, kind in lines} == dict.fromkeys(COMMANDS, "(ros.ament_python)")


@pytest.fixture(scope="module")
def install(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("colcon")
    bases = ["--build-base", folder / "build", "--install-base", folder / "install"]
    colcon(folder, "build", *bases, "--event-handlers", "console_direct+")
    return folder / "install"


@pytest.mark.parametrize("package", COMMANDS)
def test_colcon_installs_the_package(package: str, install: Path) -> None:
    prefix = install / package
    commands = prefix / "lib" / package
    found = {path.name for path in commands.iterdir()} if commands.is_dir() else set()
    assert found == COMMANDS[package]
    assert all(os.access(commands / name, os.X_OK) for name in found)
    assert (prefix / "share" / package / "package.xml").is_file()
    assert (prefix / "share/ament_index/resource_index/packages" / package).is_file()


@pytest.mark.parametrize("package", COMMANDS)
def test_colcon_installs_every_file(package: str, install: Path) -> None:
    (installed,) = (install / package).glob(f"lib/python3*/site-packages/{package}")
    assert files(installed) == files(WORKSPACE / "src" / package / package), "package_data in setup.py"


def files(folder: Path) -> set[str]:
    """All files below a folder but compiled ones."""
    paths = (path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    return {str(path) for path in paths if "__pycache__" not in path.parts}
