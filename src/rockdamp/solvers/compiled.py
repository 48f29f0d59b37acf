"""Compilation of both solvers' loops: one for each damper, and a cache that notices every edit.

Numba keeps machine code under the name of the function, its file and that file's content. It does not notice an edit of
a function or of a number in another file. So the name of each loop ends with a digest of the versions of Numba, NumPy
and SciPy and of the compiled sources: those that all dampers share, and the file of its own damper's formula. A formula
takes neither a number nor a function from another file. Edited sources find no old code, a new damper leaves that of
the others, and two versions never write one file. The files lie where Numba puts them, beside the source or in
NUMBA_CACHE_DIR; `make clean` removes them.
"""

from __future__ import annotations

import hashlib
import pickle
import warnings
from collections.abc import Callable, Sequence
from functools import cache
from importlib.metadata import version
from pathlib import Path
from types import FunctionType
from typing import Any

from numba import config, njit
from numba.extending import register_jitable

from rockdamp.errors import InputError, InputWarning

PACKAGE = Path(__file__).parents[1]
SHARED = (
    "mechanics/trilinear.py",
    "solvers/*_kernel.py",
)
VERSIONS = "\n".join(map(version, ("numba", "numpy", "scipy")))  # SciPy has the coefficients of DOP853
DAMPERS = "mechanics/damping/*.py"
# The errors by which a file of the cache shows that it is cut, empty or something else.
DAMAGED = (AttributeError, EOFError, ImportError, IndexError, KeyError, ValueError, pickle.UnpicklingError)


def _read(*patterns: str) -> dict[str, bytes]:
    return {str(path): path.read_bytes() for pattern in patterns for path in sorted(PACKAGE.glob(pattern))}


# As of the import of this module: an edit while the process runs changes nothing here.
SHARED_SOURCES, DAMPER_SOURCES = _read(*SHARED), _read(DAMPERS)


@cache
def digest(file: str) -> str:
    """Return a digest of the versions, of the shared sources and of a file, which may lie outside the package."""
    read = DAMPER_SOURCES.get(file) or (Path(file).read_bytes() if Path(file).is_file() else b"")
    content = b"\0".join([VERSIONS.encode(), *SHARED_SOURCES.values(), read])
    return hashlib.sha256(content).hexdigest()[:12]


@cache
def jitable(function: Any) -> Any:
    """Let compiled code call a function; register it once."""
    return register_jitable(function)


def specialised(functions: Sequence[Any], name: str, **stands: Callable[..., Any]) -> dict[str, Any]:
    """Return copies of functions for one damper, as a template is instantiated.

    Each may call those before it. In each copy the global names of `stands` mean these functions, and the name of an
    earlier function means its copy. Numba takes global names as constants, so each damper's loop is compiled for
    itself. Closures would do the same, but Numba's cache compares them by a pickle that differs from process to
    process. The copies' names end with `name`: Numba tells machine code apart by names, and code from the cache would
    stand for code just compiled.
    """
    names = {key: jitable(function) for key, function in stands.items()}
    copies: dict[str, Any] = {}
    for function in functions:
        copy = FunctionType(function.__code__, function.__globals__ | names | copies)
        copy.__name__ = copy.__qualname__ = f"{function.__name__}_{name}"
        copy.__doc__ = function.__doc__
        copies[function.__name__] = jitable(copy)
    return copies


def compiled(function: Any, formula: Any, **options: Any) -> Any:
    """Return a copy by `specialised` that is compiled when it is first called, or read from Numba's cache.

    The damper's `formula` may lie in a file outside the package. A damaged file of the cache raises `InputError`.
    """
    function.__name__ = function.__qualname__ = f"{function.__name__}_{digest(formula.__code__.co_filename)}"
    if config.DISABLE_JIT:
        return function
    loop = njit(error_model="numpy", nogil=True, **options)(function)
    try:
        loop.enable_caching()
    except RuntimeError:  # as of another user's tree, without a home
        _say_that_nothing_is_kept()

    def call(*arguments: Any) -> Any:
        try:
            return loop(*arguments)
        except DAMAGED as error:  # compiled code raises none of them
            place = loop.stats.cache_path
            raise InputError(f"compiled code under {place} is damaged; `make clean` removes it") from error

    return call


@cache
def _say_that_nothing_is_kept() -> None:
    places = f"neither {Path(__file__).parent} nor the user's cache can be written"
    remedy = "set NUMBA_CACHE_DIR to a folder that can be written"
    warnings.warn(f"compiled code is not kept, and each run compiles anew: {places}; {remedy}", InputWarning, 2)
