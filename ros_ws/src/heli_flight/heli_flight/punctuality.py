"""How punctual a real-time flight was, as numbers: what the bench wrote into the bag's remarks as words."""

from __future__ import annotations

import re
from collections.abc import Mapping

PERIOD = "period_jitter"
"""How late the bench began its control periods."""

FIGURES = {"median": "median_ms", "99 %": "p99_ms", "99.9 %": "p99_9_ms", "max": "max_ms"}
"""Names of the figures by the words of the remarks."""

_KEY = re.compile(rf"(latency_\w+|{PERIOD})_ms")
_FIGURE = re.compile(r"(median|99 %|99\.9 %|max) (\d+\.\d+)")


def spoken(subject: str) -> str:
    """A key of `punctuality` for people: `sensor to servo command`."""
    return subject.replace("latency_", "sensor to ").replace("_", " ")


def punctuality(remarks: Mapping[str, str]) -> dict[str, dict[str, float]]:
    """Median, quantiles and maximum [ms] of `latency_TOPIC`, from sample to command, and of `period_jitter`.

    Args:
        remarks: custom data of a bag; empty figures where it was not flown in real time.
    """
    return {
        key.removesuffix("_ms"): {FIGURES[word]: float(value) for word, value in _FIGURE.findall(text)}
        for key, text in remarks.items()
        if _KEY.fullmatch(key)
    }
