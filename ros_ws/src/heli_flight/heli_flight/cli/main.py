"""The `heli` command: one word for each job, bad input in one line and exit code 2."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence

from heli_flight.cli import interrupts  # first: everything else takes a while to load

# isort: split
from heli_common.errors import EXIT_BAD_INPUT, EXIT_INTERRUPTED, InputError
from heli_flight.cli import (
    bag,
    calibrate,
    campaign,
    chain,
    design,
    exchange,
    fly,
    identify,
    model,
    navigation,
    parameters,
    predict,
    replay,
    report,
    reproduce,
)


def parser() -> argparse.ArgumentParser:
    """All words of the command with their options."""
    top = argparse.ArgumentParser(
        prog="heli",
        description="Helicopter test bench: fly plans, look at models, design controllers, read bags.",
    )
    words = top.add_subparsers(dest="word", required=True, metavar="COMMAND")
    parts = (
        fly,
        model,
        design,
        exchange,
        identify,
        predict,
        chain,
        calibrate,
        campaign,
        navigation,
        report,
        bag,
        replay,
        reproduce,
        parameters,
    )
    for part in parts:
        part.add_parser(words)
    return top


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns the exit code."""
    options = parser().parse_args(arguments)
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
