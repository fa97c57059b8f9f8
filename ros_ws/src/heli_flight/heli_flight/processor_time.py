"""Processor time of the nodes that this process has started (Linux)."""

from __future__ import annotations

import os
from pathlib import Path


def processor_seconds() -> dict[str, float]:
    """What each child started as `python -m MODULE` has used so far, by node name [s]."""
    ticks = os.sysconf("SC_CLK_TCK")
    found = {}
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            fields = (entry / "stat").read_text().rpartition(")")[2].split()
            words = (entry / "cmdline").read_text().split("\0")
        except OSError:
            continue
        if int(fields[1]) == os.getpid() and "-m" in words:
            name = words[words.index("-m") + 1].rpartition(".")[2].removesuffix("_node")
            found[name] = (int(fields[11]) + int(fields[12])) / ticks
    return found
