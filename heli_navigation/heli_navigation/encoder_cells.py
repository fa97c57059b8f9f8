"""What a count says: between two lines always, and at a change of count exactly where one line was passed.

Half a count either way, evenly spread, has the variance count^2 / 12, but its errors are the same as long as
the count is: a filter that takes 400 of them a second as independent soon believes in the middle of the cell.
Hence two kinds of measurement:

- **A line passed.** The angle was that of the line at some instant since the last sample. At the sample it is
  half a sample's way beyond it, on average, with the variance way^2 / 12 of an instant evenly spread, and
  that of the line's own place. Errors of different passages are independent of each other.
- **The same cell.** The cell never tells more than count^2 / 12. It is taken in only if the filter itself has
  come to know less, and with just the variance that leaves it at count^2 / 12: S = v^2 / (v - count^2 / 12)
  for an angle known to v.
"""

from __future__ import annotations

import math

from heli_common.compiled import equation
from heli_navigation.filter_parameters import FilterConstants


@equation
def line_of(angle: float, c: FilterConstants) -> float:
    """The count that an encoder's angle [rad] stands for, a whole number.

    Args:
        angle: as the encoder gives it [rad].
        c: constants of the filter.
    """
    return math.floor(angle / c.cell + 0.5)


@equation
def passed(line: float, before: float, rate: float, c: FilterConstants) -> tuple[float, float]:
    """Angle [rad] and variance [rad^2] at a sample whose count differs from that of the sample before.

    Args:
        line: count now.
        before: count one sample ago, another one.
        rate: of the angle [rad/s]; if it goes the other way, the line was passed just now.
        c: constants of the filter.
    """
    side = 1.0 if line > before else -1.0
    way = min(max(side * rate * c.period, 0.0), c.cell)
    return (line - 0.5 * side) * c.cell + 0.5 * side * way, way * way / 12.0 + c.line_variance


@equation
def cell_innovation_variance(variance: float, c: FilterConstants) -> float:
    """S with which the middle of the cell is taken in; only for a variance beyond count^2 / 12 [rad^2].

    Args:
        variance: of the angle as the filter knows it [rad^2].
        c: constants of the filter.
    """
    return variance * variance / (variance - c.cell_variance)


@equation
def beyond_cell(expected: float, line: float, c: FilterConstants) -> float:
    """How far an expected angle lies outside the cell of a count [rad], with its sign; 0 inside.

    Args:
        expected: angle [rad].
        line: count.
        c: constants of the filter.
    """
    off = expected - line * c.cell
    if off > 0.5 * c.cell:
        return off - 0.5 * c.cell
    if off < -0.5 * c.cell:
        return off + 0.5 * c.cell
    return 0.0
