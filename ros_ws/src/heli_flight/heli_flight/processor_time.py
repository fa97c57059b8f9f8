"""Processor time of the nodes that this process has started (Linux)."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path


def node_of(words: list[str]) -> str:
    """Name of the node that a command line runs as `python -m MODULE`, empty for none."""
    return words[words.index("-m") + 1].rpartition(".")[2].removesuffix("_node") if "-m" in words else ""


def processor_seconds(name_of: Callable[[list[str]], str] = node_of) -> dict[str, float]:
    """What each child has used so far, by its name [s].

    Args:
        name_of: gives the name by the command line; children without one are left out.
    """
    ticks = os.sysconf("SC_CLK_TCK")
    found = {}
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            fields = (entry / "stat").read_text().rpartition(")")[2].split()
            words = (entry / "cmdline").read_text().split("\0")
        except OSError:
            continue
        if int(fields[1]) == os.getpid() and (name := name_of(words)):
            found[name] = (int(fields[11]) + int(fields[12])) / ticks
    return found
