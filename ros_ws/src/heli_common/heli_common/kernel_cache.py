"""Where the compiled functions of exactly these sources are kept, and whether they are all there.

Apart from `heli_common.compiled`, so that a program that only starts others need not load numba.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import platform
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from types import MappingProxyType

PACKAGES = (
    "heli_common",
    "heli_bench_sim",
    "heli_navigation",
    "heli_control",
    "heli_identification",
    "heli_flight",
)

MARK = "complete"
"""File in the cache folder that says that everything is compiled."""


def source_hash(chosen: Mapping[str, Sequence[str]] = MappingProxyType({}), more: bytes = b"") -> str:
    """SHA-256 over the path and text of every Python source of the installed packages.

    Args:
        chosen: by package, those of its files that count, in their order; of other packages all do.
        more: that counts, too.
    """
    digest = hashlib.sha256()
    for package in PACKAGES:
        spec = importlib.util.find_spec(package)
        if spec is None or spec.origin is None:
            continue
        root = Path(spec.origin).parent
        names = chosen.get(package)
        paths = sorted(root.rglob("*.py")) if names is None else [root / name for name in names]
        for path in paths:
            digest.update(f"{package}/{path.relative_to(root)}\0".encode())
            digest.update(path.read_bytes())
    digest.update(more)
    return digest.hexdigest()


def cache_folder() -> Path:
    """Folder of the compiled functions of exactly these sources on exactly this interpreter."""
    base = os.environ.get("HELI_CACHE") or os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    key = f"{source_hash()[:16]}-py{platform.python_version()}-numba{version('numba')}-{platform.machine()}"
    return Path(base) / "heli_bench" / key


def is_warm() -> bool:
    """Whether the kernels of exactly these sources are compiled already."""
    return (cache_folder() / MARK).is_file()
