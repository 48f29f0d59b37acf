"""Machine code of the solvers, which Numba compiles once and keeps in a folder.

Numba passes over three events in silence, or with a traceback that names no file. They get a
message here: the first compilation, a folder that cannot be written to, and damaged files in it.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable
from functools import wraps
from multiprocessing import parent_process
from pathlib import Path
from threading import Lock
from typing import Any

from numba import config, errors, njit

FIRST_COMPILATION = "Compiling the solvers, once: about half a minute"
NO_FOLDER = (
    "Compiling the solvers, which takes half a minute in every run: Numba finds no folder that it "
    "may write to. Set NUMBA_CACHE_DIR to one."
)

_lock = Lock()
_messages: set[str] = set()


def compile_cached(function: Callable[..., Any], **options: Any) -> Callable[..., Any]:
    """Return a function that is compiled when it is first called, or read from Numba's files.

    Parameters
    ----------
    function : callable
        Its qualified name is unique in its module, as Numba names the files by it.
    **options
        Options of `numba.njit`.

    Raises
    ------
    OSError
        When it is called, if its files are damaged.
    """
    if config.DISABLE_JIT:  # type: ignore[attr-defined]
        return function
    try:
        dispatcher = njit(cache=True, **options)(function)
    except RuntimeError:  # no folder can be written to
        dispatcher = njit(**options)(function)

    @wraps(function)
    def call(*arguments: Any) -> Any:
        if dispatcher.signatures:
            return dispatcher(*arguments)
        folder = dispatcher.stats.cache_path
        announce_compilation(function, folder)
        try:
            return dispatcher(*arguments)
        except errors.NumbaError:
            raise
        except Exception as error:
            # It was compiled or read, and failed when it ran; or there are no files.
            if dispatcher.signatures or folder is None:
                raise
            files = Path(folder) / f"{_module_name(function)}.{function.__qualname__}-*.nb*"
            raise OSError(
                f"the machine code of the solvers is damaged ({error!r}); delete {files}"
            ) from error

    return call


def announce_compilation(function: Callable[..., Any], folder: str | None) -> None:
    """Say on standard error, once in a process, that a compilation of some length begins.

    Where a folder holds machine code of the module, one more function takes only a moment.
    """
    message = NO_FOLDER
    if folder is not None:
        version = f"py{sys.version_info.major}{sys.version_info.minor}"
        if any(Path(folder).glob(f"{_module_name(function)}.*.{version}*.nbi")):
            return
        message = FIRST_COMPILATION
    with _lock:
        if message not in _messages and parent_process() is None:
            print(message, file=sys.stderr, flush=True)
        _messages.add(message)


def _module_name(function: Callable[..., Any]) -> str:
    """Return the name of a function's module in the names of Numba's files."""
    return Path(inspect.getfile(function)).stem
