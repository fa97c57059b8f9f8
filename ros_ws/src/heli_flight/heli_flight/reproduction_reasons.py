"""Why a printed figure is not reproduced: what is known, in words, by experiment and key of the comparison."""

from __future__ import annotations

REASONS: dict[str, str] = {}
