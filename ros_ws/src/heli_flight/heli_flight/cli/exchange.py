"""`heli export` and `heli import`: model and controller files to .mat files for other tools, and back."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from heli_control.exchange import read_file, read_mat, write_mat


def add_parser(words: Any) -> None:
    """Add `export` and `import` to the command."""
    for word, given, made, function in (
        ("export", "model or controller file", ".mat file", run_export),
        ("import", ".mat file", "model or controller file", run_import),
    ):
        text = f"from a {given} to a {made}" if word == "export" else f"from a {given} to a {made}, checked"
        part = words.add_parser(word, help=text, description=f"{text.capitalize()}.")
        part.add_argument("file", type=Path, metavar="FILE", help=given)
        if word == "export":
            part.add_argument("--to", choices=("mat",), default="mat", help="format (default: mat)")
        part.add_argument("--out", type=Path, required=True, help=f"{made} to write")
        part.set_defaults(func=function)


def run_export(options: argparse.Namespace) -> int:
    """Read YAML, write .mat."""
    write_mat(read_file(options.file), options.out)
    sys.stdout.write(f"{options.to} {options.out}\n")
    return 0


def run_import(options: argparse.Namespace) -> int:
    """Read .mat, write YAML."""
    file = read_mat(options.file)
    file.write(options.out)
    sys.stdout.write(f"{type(file).__name__.removesuffix('File').lower()} {options.out}\n")
    return 0
