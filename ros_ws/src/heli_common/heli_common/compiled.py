"""Numba with a cache that knows when any source of this project has changed.

Numba's own cache looks only at the file a function stands in, so an edit in an imported function would go
unnoticed. The cache folder is therefore named by a hash of every Python source of the six packages and by
the versions that decide the machine code. Importing this module sets the folder; nothing else may import
numba before it.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from typing import TypeVar, cast

from heli_common.kernel_cache import cache_folder

Function = TypeVar("Function", bound=Callable[..., object])

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
