"""Numba with a cache that knows when any source of this project has changed.

Numba's own cache looks only at the file a function stands in, so an edit in an imported function would go
unnoticed. The cache folder is therefore named by a hash of every Python source of the six packages and by
the versions that decide the machine code. Importing this module sets the folder; nothing else may import
numba before it.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import platform
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib.metadata import version
from pathlib import Path
from types import MappingProxyType
from typing import TypeVar, cast

Function = TypeVar("Function", bound=Callable[..., object])

PACKAGES = (
    "heli_common",
    "heli_bench_sim",
    "heli_navigation",
    "heli_control",
    "heli_identification",
    "heli_flight",
)


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


os.environ.setdefault("NUMBA_CACHE_DIR", str(cache_folder()))
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numba  # noqa: E402  (the cache folder must be known first)
from numba.extending import register_jitable  # noqa: E402

_jit = partial(numba.njit, cache=True, fastmath=False, error_model="numpy")


def compiled(function: Function) -> Function:
    """Compile to machine code on first use and keep it on disk; IEEE order of operations is preserved."""
    return cast(Function, _jit()(function))


def equation(function: Function) -> Function:
    """The same for a small equation: it becomes part of whatever calls it, to share common terms."""
    return cast(Function, _jit(forceinline=True)(function))


def callable_too(function: Function) -> Function:
    """Let compiled code call a plain function, which stays as it is for everybody else."""
    return cast(Function, register_jitable(fastmath=False, error_model="numpy")(function))
