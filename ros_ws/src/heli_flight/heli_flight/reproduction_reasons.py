"""Why a printed figure is not reproduced, as far as it is known: by experiment and key of the comparison."""

from __future__ import annotations

REASONS: dict[str, str] = {}
