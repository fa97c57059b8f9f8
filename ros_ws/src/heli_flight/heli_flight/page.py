"""Pages: one HTML file each that needs nothing else, from templates that extend `page.html`.

A template fills the blocks `badges`, `nav` and `main` (and `style`); `tables.html` has macros for tables,
figures and tiles. Style and script are in the page once.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from plotly.offline import get_plotlyjs

from heli_common.errors import InputError
from heli_common.files import write_atomically
from heli_flight.picture import data_uri

TEMPLATES = Path(__file__).parent / "templates"


class Titled(Protocol):
    """What a page says of any figure: key of links and files, title and caption."""

    @property
    def key(self) -> str: ...  # noqa: D102
    @property
    def title(self) -> str: ...  # noqa: D102
    @property
    def caption(self) -> str: ...  # noqa: D102


def page_environment() -> Environment:
    """Where the pages' templates come from; a name that is not given is an error."""
    return Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def render_page(template: str, *, kind: str, heading: str, static: bool, **about: Any) -> str:
    """The text of a page.

    Args:
        template: file in `templates` that extends `page.html`.
        kind: what it is, e.g. `flight report`.
        heading: at the top and in the browser's title.
        static: whether its figures are pictures, so that it needs no script.
        about: what the template's blocks need.
    """
    script = "" if static else get_plotlyjs()
    return (
        page_environment().get_template(template).render(kind=kind, heading=heading, script=script, **about)
    )


def live(figure: Titled, plot: str, timed: bool = False) -> dict[str, Any]:
    """A figure for the macro `draw`, drawn by the browser.

    Args:
        figure: of which title and caption are taken.
        plot: its data and layout for plotly, JSON.
        timed: whether zooming it zooms all others that are.
    """
    return {**_about(figure), "plot": plot.replace("<", "\\u003c"), "timed": timed}


def still(figure: Titled, png: bytes) -> dict[str, Any]:
    """A figure for the macro `draw` as a picture.

    Args:
        figure: of which title and caption are taken.
        png: the file's content.
    """
    return {**_about(figure), "picture": data_uri(png)}


def _about(figure: Titled) -> dict[str, Any]:
    return {"key": figure.key, "title": figure.title, "caption": figure.caption}


def write_page(page: Path, html: str, numbers: Path, document: Any, pictures: Mapping[Path, bytes]) -> None:
    """Write a page, its numbers and its pictures, each whole or not at all.

    Args:
        page: the HTML file. html: its text.
        numbers: the JSON file. document: its content; NaN is refused.
        pictures: content by path.

    Raises:
        InputError: one of them cannot be written.
    """
    try:
        write_atomically(page, html)
        write_atomically(numbers, json.dumps(document, indent=2, allow_nan=False) + "\n")
        for path, content in pictures.items():
            write_atomically(path, content)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", file=error.filename or page) from None
