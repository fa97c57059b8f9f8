"""`heli parameters`: every parameter of every node as a ROS parameter file."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from heli_common.files import write_atomically
from heli_flight.parameter_file import parameter_file


def add_parser(words: Any) -> None:
    """Add `parameters` to the command."""
    text = "Print every parameter of every node with its default, unit, range and origin."
    command = words.add_parser("parameters", help="parameter file of all nodes", description=text)
    command.add_argument("--out", type=Path, help="write to this file instead")
    command.set_defaults(func=run)


def run(options: argparse.Namespace) -> int:
    """Print or write the file."""
    if options.out is not None:
        write_atomically(options.out, parameter_file())
    else:
        sys.stdout.write(parameter_file())
    return 0
