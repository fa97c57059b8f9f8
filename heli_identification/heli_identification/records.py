"""The data an estimation works on: deviations of inputs and outputs on a fixed grid, in pieces."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Record:
    """One uninterrupted piece of data.

    Attributes:
        name: where it comes from, for messages.
        period: sample time [s].
        inputs: m names. outputs: p names.
        u: what moves the plant, shape (N, m), SI.
        y: what is measured of it at the same instants, shape (N, p), SI.
        r: external signal within u, shape (N, m), or None.

    Raises:
        ValueError: shapes that do not fit.
    """

    name: str
    period: float
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    u: Array
    y: Array
    r: Array | None = None

    def __post_init__(self) -> None:
        n = len(self.u)
        if self.u.shape != (n, len(self.inputs)) or self.y.shape != (n, len(self.outputs)):
            raise ValueError(f"{self.name}: inputs {self.u.shape} and outputs {self.y.shape} do not fit")
        if self.r is not None and self.r.shape != self.u.shape:
            raise ValueError(f"{self.name}: external signal {self.r.shape}, inputs {self.u.shape}")

    def __len__(self) -> int:
        return len(self.u)

    @property
    def duration(self) -> float:
        """Length [s]."""
        return len(self) * self.period

    def piece(self, begin: int, end: int) -> Record:
        """Samples begin .. end - 1."""
        return Record(
            self.name,
            self.period,
            self.inputs,
            self.outputs,
            self.u[begin:end],
            self.y[begin:end],
            None if self.r is None else self.r[begin:end],
        )


def data_hash(records: Sequence[Record]) -> str:
    """SHA-256 over names and numbers of the records, 64 hex digits."""
    digest = hashlib.sha256()
    for record in records:
        digest.update(f"{record.period!r} {record.inputs} {record.outputs}\0".encode())
        for part in (record.u, record.y, record.r):
            if part is not None:
                digest.update(np.ascontiguousarray(part).tobytes())
    return digest.hexdigest()
