"""A fault asked for while flying, in one line of text: `encoder_stuck encoder=arm_1 for_s=2`.

The keys are those of a plan (see `fault_words`) without `at_s`, because a request begins at once.
"""

from __future__ import annotations

from heli_bench_sim.fault_words import read_fault
from heli_bench_sim.faults import Fault
from heli_common.errors import InputError

LONGEST_REQUEST = 200
"""Characters of a request; a longer one is refused."""

_EXAMPLE = "for example encoder_stuck encoder=arm_1 for_s=2"


def fault_from_text(text: str, *, now_ns: int) -> Fault:
    """The fault that a request asks for, beginning now.

    Args:
        text: kind, then `key=value` for each setting, with blanks between them.
        now_ns: stamp of its start [ns]; before the first sample, that sample.

    Raises:
        InputError: names the key, the value and what is allowed.
    """
    if len(text) > LONGEST_REQUEST:
        raise InputError(f"{len(text)} characters are no fault", allowed=_EXAMPLE, key="fault")
    kind, *words = text.split() or [""]
    settings: dict[str, object] = {"kind": kind}
    for word in words:
        key, _, value = word.partition("=")
        if not key or not value:
            raise InputError(f"{word!r} is no setting", allowed=_EXAMPLE, key="fault")
        if key in settings:
            raise InputError("stands twice", allowed="each key once", key=f"fault.{key}")
        settings[key] = _scalar(value)
    return read_fault(settings, file=None, key="fault", now_ns=max(now_ns, 0))


def _scalar(word: str) -> object:
    """A word of a request as the number it is, else as text."""
    for number in (int, float):
        try:
            return number(word)
        except ValueError:
            continue
    return word
