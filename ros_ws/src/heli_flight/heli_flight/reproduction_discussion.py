"""What is to be said of each experiment beside its tables: paragraphs of the page."""

from __future__ import annotations

WORDS: dict[str, tuple[str, ...]] = {
    "F2": (
        "The room's gusts are calibrated on the LQ row (heli calibrate gusts); the other rows are "
        "predictions. The gusts are slow beside every loop, so the gain at their corner frequency decides, "
        "as the table from the gains alone says. Table 5.2 and the text beside it cannot both be read "
        "literally: a sigma of 4.30 cm does not fit a largest deviation of less than 4 cm. Discussed in "
        "docs/reproduction.md.",
    ),
    "F4": (
        "Only every second sample at 100 Hz is latched by the servo frames. Lost: stopped by the "
        "supervisor or in touch with a stop, in the air.",
    ),
}
