"""The `heli` command: one word for each job, bad input in one line and exit code 2."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from importlib import import_module

from heli_flight.cli import interrupts  # first: everything else takes a while to load

# isort: split
from heli_common.errors import EXIT_BAD_INPUT, EXIT_INTERRUPTED, InputError

WORDS = {
    "fly": "fly",
    "verify": "verify",
    "model": "model",
    "design": "design",
    "export": "exchange",
    "import": "exchange",
    "identify": "identify",
    "predict": "predict",
    "chain": "chain",
    "calibrate": "calibrate",
    "campaign": "campaign",
    "navigation": "navigation",
    "report": "report",
    "bag": "bag",
    "replay": "replay",
    "reproduce": "reproduce",
    "parameters": "parameters",
    "topic": "graph",
    "node": "graph",
    "param": "graph",
    "service": "graph",
}
"""Module of `heli_flight.cli` by word: only that of the given word is loaded, all of them for help."""


def parser(word: str = "") -> argparse.ArgumentParser:
    """The command with its options: of one word, or of all where the word is none of them."""
    top = argparse.ArgumentParser(
        prog="heli",
        description="Helicopter test bench: fly plans, look at models, design controllers, read bags.",
    )
    words = top.add_subparsers(dest="word", required=True, metavar="COMMAND")
    parts = (WORDS[word],) if word in WORDS else dict.fromkeys(WORDS.values())
    for part in parts:
        import_module(f"heli_flight.cli.{part}").add_parser(words)
    return top


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns the exit code."""
    given = sys.argv[1:] if arguments is None else arguments
    options = parser(given[0] if given else "").parse_args(given)
    interrupts.while_running()
    try:
        code: int = options.func(options)
        sys.stdout.flush()
    except InputError as error:
        sys.stderr.write(f"heli {options.word}: {error}\n")
        return EXIT_BAD_INPUT
    except KeyboardInterrupt:
        sys.stderr.write(f"heli {options.word}: interrupted\n")
        return EXIT_INTERRUPTED
    except BrokenPipeError:
        # the reader of our output has gone (`heli ... | head`): nothing is left to say
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    return code


if __name__ == "__main__":
    sys.exit(main())
