"""Dependencies of a module: a made-up package by hand, and what Python loads for a flight."""

import subprocess
import sys
from pathlib import Path

import pytest

import heli_flight
from heli_flight.imported_sources import imported_sources
from heli_flight.reproduction_store import flying_sources

ROOT = Path(heli_flight.__file__).parent


def test_made_up_package(tmp_path: Path) -> None:
    root = tmp_path / "made_up"
    for name, text in {
        "__init__": "",
        "first": "import json\nfrom made_up.second import thing\nfrom other.unused import it",
        "second": "def f():\n    from made_up import third as other",
        "third": "import made_up.inner.fourth as fourth",
        "unused": "import made_up.first",
        "inner/__init__": "from .fifth import one",
        "inner/fourth": "from ..first import back",
        "inner/fifth": "",
    }.items():
        path = root / f"{name}.py"
        path.parent.mkdir(exist_ok=True, parents=True)
        path.write_text(text)
    wanted = {"__init__", "first", "second", "third", "inner/__init__", "inner/fourth", "inner/fifth"}
    assert set(imported_sources(root, "first")) == {f"{name}.py" for name in wanted}
    assert imported_sources(root, "inner.fifth") == ("inner/fifth.py",)
    with pytest.raises(FileNotFoundError):
        imported_sources(root, "sixth")


def test_flights_depend_on_all_that_python_loads_for_them() -> None:
    """The twin: a fresh interpreter imports the flights and says what it has loaded of this package."""
    say = "import sys, heli_flight.reproduction_flights\nfor each in sys.modules.values():\n"
    say += "    print(getattr(each, '__file__', None))"
    run = subprocess.run([sys.executable, "-c", say], capture_output=True, text=True, check=True)
    paths = {Path(line) for line in run.stdout.splitlines()}
    loaded = {path.relative_to(ROOT).as_posix() for path in paths if path.is_relative_to(ROOT)}
    sources = flying_sources()
    assert {"plan.py", "compiled_control.py", "components.py", "in_process.py"} <= loaded <= set(sources)
    assert "page.py" not in sources and not any(name.startswith("cli/") for name in sources)
