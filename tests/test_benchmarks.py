"""Every benchmark can be loaded: a name that has moved is noticed before somebody wants a figure."""

from __future__ import annotations

import ast
import importlib
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "benchmarks"
GUESTS = {"identification_peers"}
"""Runs in an environment that has another project's package."""


@pytest.mark.parametrize("name", sorted({path.stem for path in FOLDER.glob("*.py")} - GUESTS))
def test_a_benchmark_loads(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(FOLDER))
    assert importlib.import_module(name).__doc__


def test_guests_are_benchmarks_that_exist() -> None:
    for name in GUESTS:
        ast.parse((FOLDER / f"{name}.py").read_text())
