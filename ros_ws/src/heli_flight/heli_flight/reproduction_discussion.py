"""What is to be said of each experiment beside its tables: paragraphs of the page."""

from __future__ import annotations

WORDS: dict[str, tuple[str, ...]] = {}
