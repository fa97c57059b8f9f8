"""Whether a page opens in a real browser without asking the network, without an error, with all its figures.

    python tests/page_check.py PAGE.html [--picture FILE.png]

prints what is wrong, a line each, and exits with 1; with 0 if nothing is. The browser is Chromium (`chromium`
in the path, or what HELI_BROWSER names), without a screen and with a profile of its own. It cannot
resolve any host name; what it tried to reach stands in its own log of network events all the same.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from html.parser import HTMLParser
from pathlib import Path

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
TALL = 10_000
"""Height of the window [pixels], so that a picture shows the whole page."""

_CONSOLE = re.compile(r":CONSOLE[:(]\d+\)?\] ?(.*)")
_OWN = ("file:", "data:", "blob:", "about:", "chrome:", "chrome-extension:", "devtools:")


@dataclass(frozen=True)
class Visit:
    """What happened when a page was opened.

    Attributes:
        requests: addresses that the page asked for and that are not in itself.
        console: lines on the console; a page without fault has none.
        missing: figures that have no drawing in them.
        figures: number of figures.
    """

    requests: tuple[str, ...]
    console: tuple[str, ...]
    missing: tuple[str, ...]
    figures: int

    @property
    def problems(self) -> list[str]:
        """All that is wrong, a line each."""
        return [
            *(f"asks the network: {address}" for address in self.requests),
            *(f"console: {line}" for line in self.console),
            *(f"not drawn: {key}" for key in self.missing),
        ]


def browser() -> str:
    """Path of the browser.

    Raises:
        FileNotFoundError: there is none; says how to get it.
    """
    wanted = os.environ.get("HELI_BROWSER")
    found = shutil.which(wanted) if wanted else next(filter(None, map(shutil.which, NAMES)), None)
    if found is None:
        raise FileNotFoundError(
            f"no browser ({wanted or ', '.join(NAMES)}): apt-get install chromium, or set HELI_BROWSER"
        )
    return found


def visit(page: Path, picture: Path | None = None, *, width: int = 1400, dark: bool = False) -> Visit:
    """Open a page until it is at rest, and say what happened.

    Args:
        page: HTML file. picture: PNG file of the whole window that is written, if given.
        width: of the window [pixels]. dark: whether the visitor prefers dark colours.

    Raises:
        FileNotFoundError: no browser, or no such page.
        RuntimeError: the browser failed or took longer than three minutes.
    """
    if not page.is_file():
        raise FileNotFoundError(f"{page}: no such page")
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "net.json"
        words = [
            browser(),
            *("--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars"),
            *("--no-first-run", "--disable-background-networking", "--disable-component-update"),
            *("--disable-sync", "--disable-default-apps", "--disable-extensions", "--no-proxy-server"),
            "--host-resolver-rules=MAP * ~NOTFOUND",
            *(f"--user-data-dir={folder}/profile", f"--log-net-log={log}", "--net-log-capture-mode=Default"),
            *("--enable-logging=stderr", "--v=0", f"--window-size={width},{TALL}"),
            "--virtual-time-budget=30000",
        ]
        if dark:
            words.append("--blink-settings=preferredColorScheme=0")
        if picture is not None:
            words.append(f"--screenshot={picture.resolve()}")
        words += ["--dump-dom", page.resolve().as_uri()]
        try:
            done = subprocess.run(words, capture_output=True, timeout=180, check=False, cwd=folder)
        except subprocess.TimeoutExpired:
            raise RuntimeError(f"{words[0]}: still busy with {page} after 180 s") from None
        said = done.stderr.decode(errors="replace")
        if done.returncode or not log.exists():
            raise RuntimeError(f"{words[0]} failed with {done.returncode}: {said[-500:]}")
        requests = _requests(log.read_text(errors="replace"))
    figures = _Figures()
    figures.feed(done.stdout.decode(errors="replace"))
    return Visit(
        requests,
        tuple(match[1].strip() for line in said.splitlines() if (match := _CONSOLE.search(line))),
        tuple(key for key, drawn in figures.drawn.items() if not drawn),
        len(figures.drawn),
    )


def _requests(text: str) -> tuple[str, ...]:
    """Addresses that the page asks for, from a log of network events.

    What the browser asks for itself (the time, updates) has no page as its initiator.
    """
    try:
        log = json.loads(text)
    except json.JSONDecodeError:
        # a browser that was stopped leaves the list open
        log = json.loads(text.rstrip().rstrip(",") + "]}")
    start = log["constants"]["logEventTypes"]["URL_REQUEST_START_JOB"]
    asked = [event.get("params", {}) for event in log["events"] if event["type"] == start]
    addresses = [str(one.get("url", "")) for one in asked if one.get("initiator") != "not an origin"]
    return tuple(dict.fromkeys(url for url in addresses if url and not url.startswith(_OWN)))


class _Figures(HTMLParser):
    """Which elements of class `plot` hold a line or a point, and which pictures have content."""

    def __init__(self) -> None:
        super().__init__()
        self.drawn: dict[str, bool] = {}
        self._inside, self._depth = "", 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        about = dict(attrs)
        classes = (about.get("class") or "").split()
        if tag == "div" and self._inside:
            self._depth += 1
        elif tag == "div" and "plot" in classes:
            self._inside, self._depth = about.get("id") or "without id", 1
            self.drawn[self._inside] = False
        elif tag == "img":
            self.drawn[about.get("alt") or "picture"] = bool(about.get("src"))
        if self._inside and tag == "path" and {"js-line", "point"} & set(classes):
            self.drawn[self._inside] = True

    def handle_endtag(self, tag: str) -> None:
        if tag == "div" and self._inside:
            self._depth -= 1
            if not self._depth:
                self._inside = ""


def main() -> int:
    """Check one page."""
    parser = argparse.ArgumentParser(description="Open a page in a browser and say what is wrong with it.")
    parser.add_argument("page", type=Path, help="HTML file")
    parser.add_argument("--picture", type=Path, metavar="FILE.png", help="write what the page looks like")
    parser.add_argument("--width", type=int, default=1400, help="of the window in pixels")
    parser.add_argument("--dark", action="store_true", help="as a visitor who prefers dark colours")
    options = parser.parse_args()
    try:
        seen = visit(options.page, options.picture, width=options.width, dark=options.dark)
    except (FileNotFoundError, RuntimeError) as error:
        sys.stderr.write(f"{error}\n")
        return 2
    sys.stdout.writelines(f"{line}\n" for line in seen.problems or [f"{seen.figures} figures, nothing wrong"])
    return 1 if seen.problems else 0


if __name__ == "__main__":
    sys.exit(main())
