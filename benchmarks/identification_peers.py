"""SIPPY's ARMAX on a record of benchmarks/identification.py: time and one-step fit, as one JSON line.

Needs neither this project nor its environment: run by any Python that has sippy-unipi (decision 4). ARMAX
knows no structure and no state: one equation per output, orders chosen below, all inputs; iterative least
squares.
"""

from __future__ import annotations

import importlib.metadata
import json
import os
import sys
import time
from typing import Any

ORDERS = (3, 2, 2)
"""Of denominator, numerators and noise."""


def armax(path: str) -> dict[str, Any]:
    """Time of the identification and fit of its one-step prediction per output."""
    import numpy as np
    from sippy_unipi import system_identification

    data = np.load(path)
    u, y = data["u"].T.copy(), data["y"].T.copy()
    outputs, inputs = len(y), len(u)
    na, nb, nc = ORDERS
    begin = time.process_time()
    model = system_identification(
        y,
        u,
        "ARMAX",
        centering="MeanVal",
        tsample=float(data["period"]),
        ARMAX_orders=[
            [na] * outputs,
            [[nb] * inputs] * outputs,
            [nc] * outputs,
            [[1] * inputs] * outputs,
        ],
    )
    used = time.process_time() - begin
    predicted = np.asarray(model.Yid)
    error = np.sqrt(np.mean((y - predicted) ** 2, axis=1))
    fit = 100.0 * (1.0 - error / y.std(axis=1))
    return {"seconds": used, "one_step_fit_percent": fit.tolist(), "orders": list(ORDERS)}


def main() -> None:
    """Answer with one line on standard output."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    try:
        answer = armax(sys.argv[1]) | {"version": importlib.metadata.version("sippy-unipi")}
    except Exception as error:  # a missing or another peer must not end the benchmark
        answer = {"missing": f"{type(error).__name__}: {error}"}
    answers.write(json.dumps(answer) + "\n")
    answers.flush()


if __name__ == "__main__":
    main()
