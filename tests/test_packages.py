"""The six packages, their scripts and their pinned requirements fit together."""

import ast
import os
import re
import subprocess
from pathlib import Path

import pytest
from catkin_pkg.package import Package, parse_package

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = {
    "heli_common": ROOT / "ros_ws/src/heli_common",
    "heli_bench_sim": ROOT / "heli_bench_sim",
    "heli_navigation": ROOT / "heli_navigation",
    "heli_control": ROOT / "heli_control",
    "heli_identification": ROOT / "heli_identification",
    "heli_flight": ROOT / "ros_ws/src/heli_flight",
}
LINKED = ("heli_bench_sim", "heli_navigation", "heli_control", "heli_identification")
SCRIPTS = sorted((ROOT / "ros_ws/scripts").glob("*.sh"))
SCRIPT_OF_MODULE = {"recorder": "record", "replay": "replay"}


def setup_arguments(package: str) -> dict[str, object]:
    """The literal keyword arguments of the setup() call."""
    tree = ast.parse((FOLDERS[package] / "setup.py").read_text(encoding="utf-8"))
    (call,) = (
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "setup"
    )
    return {
        keyword.arg: ast.literal_eval(keyword.value)
        for keyword in call.keywords
        if keyword.arg and not isinstance(keyword.value, ast.Call)
    }


def console_scripts() -> list[tuple[str, str, str, str]]:
    """(package, command, module, function) of every command in the six setup.py."""
    found = []
    for package in FOLDERS:
        points = setup_arguments(package)["entry_points"]
        assert isinstance(points, dict)
        for line in points.get("console_scripts", []):
            command, module, function = re.fullmatch(r"(\w+) = ([\w.]+):(\w+)", line).groups()
            found.append((package, command, module, function))
    return found


def source_of(module: str) -> Path:
    package, *rest = module.split(".")
    return FOLDERS[package].joinpath(package, *rest).with_suffix(".py")


def declared(package: str) -> tuple[Package, set[str]]:
    manifest = parse_package(str(FOLDERS[package] / "package.xml"))
    return manifest, {dependency.name for dependency in manifest.exec_depends}


@pytest.mark.parametrize("package", FOLDERS)
def test_package_xml_fits_setup_py(package: str) -> None:
    manifest, _ = declared(package)
    arguments = setup_arguments(package)
    assert manifest.name == arguments["name"] == FOLDERS[package].name == package
    assert manifest.version == arguments["version"]
    assert manifest.get_build_type() == "ament_python"
    assert arguments["package_dir"] == {"": "."}, "editable installs would find an empty namespace package"
    assert arguments["extras_require"] == {"test": ["pytest"]}, "colcon test would run nothing and pass"
    assert (FOLDERS[package] / "resource" / package).is_file()
    assert (FOLDERS[package] / package / "py.typed").is_file()


def test_all_packages_have_one_version() -> None:
    assert len({setup_arguments(package)["version"] for package in FOLDERS}) == 1


@pytest.mark.parametrize("package", FOLDERS)
def test_package_xml_declares_what_is_imported(package: str) -> None:
    used = set()
    for path in (FOLDERS[package] / package).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                used |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                used.add(node.module.partition(".")[0])
    used = {name for name in used if re.fullmatch(r"heli_\w+|rclpy|\w+_(msgs|srvs|interfaces)", name)}
    _, dependencies = declared(package)
    assert used - {package} <= dependencies, "missing in package.xml"


@pytest.mark.parametrize("package", LINKED)
def test_workspace_links_to_the_package(package: str) -> None:
    link = ROOT / "ros_ws/src" / package
    assert link.is_symlink()
    assert link.readlink() == Path("../..") / package
    assert link.resolve() == FOLDERS[package]


@pytest.mark.parametrize(("package", "command", "module", "function"), console_scripts())
def test_command_has_its_function(package: str, command: str, module: str, function: str) -> None:
    assert module.partition(".")[0] == package
    tree = ast.parse(source_of(module).read_text(encoding="utf-8"))
    names = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    for node in tree.body:
        if isinstance(node, ast.ImportFrom):
            names |= {alias.asname or alias.name for alias in node.names}
    assert function in names


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.name)
def test_script_is_sound(script: Path) -> None:
    assert script.name.startswith("_") or os.access(script, os.X_OK)
    subprocess.run(["bash", "-n", script], check=True)


@pytest.mark.parametrize(
    ("command", "module"),
    [(command, module) for _, command, module, _ in console_scripts() if command.endswith("_node")],
)
def test_every_node_has_a_script(command: str, module: str) -> None:
    name = command.removesuffix("_node")
    script = ROOT / "ros_ws/scripts" / f"{SCRIPT_OF_MODULE.get(name, name)}.sh"
    assert script.read_text(encoding="utf-8").endswith(f'\nrun python -m {module} "$@"\n')


def pins(file: str) -> dict[str, str]:
    """Name -> version of every line; fails where a line is not pinned and hashed."""
    text = (ROOT / file).read_text(encoding="utf-8")
    found = {}
    for line in text.replace("\\\n", " ").splitlines():
        if line.startswith("#"):
            continue
        requirement, *hashes = re.split(r"\s+--hash=", line.strip())
        name, version = re.fullmatch(r"([a-z0-9-]+)==(\S+)(?: ; .+)?", requirement).groups()
        assert hashes and all(re.fullmatch(r"sha256:[0-9a-f]{64}", item) for item in hashes), line
        found[name] = version
    return found


@pytest.mark.parametrize("name", ["requirements", "requirements-dev"])
def test_requirements_are_pinned_and_hold_no_address(name: str) -> None:
    text = (ROOT / f"{name}.txt").read_text(encoding="utf-8")
    assert not re.search(r"://|^-[-a-z]", text, re.MULTILINE)
    assert not re.search(r"(?:^|\s)[/~]\w", text), "a path of somebody's machine"
    wanted = [
        re.match(r"[\w-]+", line).group().lower()
        for line in (ROOT / f"{name}.in").read_text(encoding="utf-8").splitlines()
        if line and not line.startswith(("-r", "#"))
    ]
    assert set(wanted) <= set(pins(f"{name}.txt"))


def test_testing_has_the_versions_of_flying() -> None:
    assert pins("requirements.txt").items() <= pins("requirements-dev.txt").items()
