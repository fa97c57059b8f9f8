"""`heli design`: from a model file to a controller file."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from heli_common.model_file import ModelFile
from heli_control.lq import LqWeights, design_lq


def add_parser(words: Any) -> None:
    """Add `design` to the command."""
    design = words.add_parser("design", help="design a controller from a model file")
    kinds = design.add_subparsers(dest="kind", required=True, metavar="KIND")
    lq = kinds.add_parser(
        "lq",
        help="linear quadratic attitude and velocity controller",
        description="Linear quadratic controller at 100 Hz from a model file (source sec. 3.2.2, 3.2.3).",
    )
    lq.add_argument("--model", type=Path, required=True, help="model file (heli model linearize --out)")
    lq.add_argument("--out", type=Path, required=True, help="controller file to write")
    lq.add_argument("--json", action="store_true", help="print gains and poles as one JSON object")
    lq.set_defaults(func=run_lq)


def run_lq(options: argparse.Namespace) -> int:
    """Design, write, say what came out."""
    controller = design_lq(ModelFile.read(options.model), LqWeights())
    controller.write(options.out)
    if options.json:
        sys.stdout.write(json.dumps(controller.mapping()) + "\n")
    else:
        sys.stdout.write(f"controller {options.out}\n")
    return 0
