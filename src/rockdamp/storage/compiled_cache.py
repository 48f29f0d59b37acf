"""Numba's cache with a checksum in each of its files: a damaged one is compiled again, not run.

Numba unpickles what it finds and runs the code in it. An empty file is an EOFError, a cut one an UnpicklingError, and a
flipped bit may end the process.

Code is kept under the source that it was compiled from. Numba reads the source's file when a function is first called;
where the file was edited since it was imported, that would keep the old code under the new source, for every process.

A copied tree finds the code of the tree: what a function closes over counts by what it computes. Numba counts it by its
pickle, which holds the place of the file and depends on how the process was started.

Processes write at the same time, on one machine or on the nodes of a cluster that share the folder. Numba numbers the
files of machine code: two processes may give one number to code for two processors, or of two versions of the source.
Here the name of such a file follows from what is in it: at worst an entry of the index is lost, and compiled again.
"""

from __future__ import annotations

import glob
import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any, BinaryIO

from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.runtime.nrt import rtsys

DIGEST = hashlib.sha256().digest_size  # bytes, at the end of each file; what unpickles it stops before


class CheckedFile(IndexDataCacheFile):
    """The files of one function's cache; a damaged one is deleted, and counts as missing."""

    def save(self, key: Any, data: Any) -> None:
        """Write machine code, then the index that names it; take away what the index does not name."""
        entries = self._load_index()
        content = hashlib.sha256(repr((key, self._source_stamp)).encode()).hexdigest()
        entries[key] = self._data_name(int(content[:12], 16))
        self._save_data(entries[key], data)
        self._save_index(entries)
        for path in Path(self._cache_path).glob(glob.escape(self._index_name[: -len("nbi")]) + "*.nbc"):
            if path.name not in entries.values():
                path.unlink(missing_ok=True)

    def _load_index(self) -> dict[Any, str]:
        return super()._load_index() if _probe(self._index_path) else {}

    def _load_data(self, name: str) -> Any:
        path = self._data_path(name)
        if not _probe(path):
            raise FileNotFoundError(path)  # Numba compiles again
        return super()._load_data(name)

    @contextmanager
    def _open_for_write(self, filepath: str) -> Iterator[BinaryIO]:
        with super()._open_for_write(filepath) as file:
            yield file
            file.flush()
            with open(file.name, "rb") as written:
                digest = hashlib.file_digest(written, "sha256").digest()
            file.write(digest)


def _probe(path: str) -> bool:
    """Whether a file is what was written; delete it if it is not."""
    try:
        with open(path, "rb") as file:
            content = file.read()
    except OSError:
        return False
    if hashlib.sha256(content[:-DIGEST]).digest() == content[-DIGEST:]:
        return True
    with suppress(OSError):
        os.unlink(path)
    return False


class _CheckedCache(FunctionCache):
    def __init__(self, function: Any, source: str) -> None:
        super().__init__(function)
        self._cache_file = CheckedFile(self._cache_path, self._impl.filename_base, source)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return cached code, ready to run, or None.

        Numba would first import what it compiles with, a quarter of a second; it does so where nothing is cached, too.
        """
        rtsys.initialize(target_context)  # the code calls it
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)

    def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        meant = hashlib.sha256(repr(_meaning(self._py_func)).encode()).hexdigest()
        return (sig, codegen.magic_tuple(), meant)


def _meaning(value: Any) -> Any:
    """Return what a function computes, with all that it closes over, wherever its file lies."""
    value = getattr(value, "py_func", value)  # of a compiled function
    if isinstance(value, FunctionType):
        return _meaning(value.__code__), [_meaning(cell.cell_contents) for cell in value.__closure__ or ()]
    if isinstance(value, CodeType):
        return value.co_code, value.co_names, value.co_varnames, [_meaning(constant) for constant in value.co_consts]
    return repr(value)


def digest_of(file: str) -> str:
    """Return the digest of a module's file; for the module's own use, when it is imported."""
    with open(file, "rb") as source:
        return hashlib.file_digest(source, "sha256").hexdigest()


def checked(compiled: Any, source: str) -> Any:
    """Return a function that Numba compiles and caches, with a cache that is checked; any other as it is.

    Parameters
    ----------
    compiled : callable
    source : str
        Digest of what it is compiled from, under which the code is kept.
    """
    if hasattr(compiled, "enable_caching"):  # not with NUMBA_DISABLE_JIT, which leaves plain Python
        compiled._cache = _CheckedCache(compiled.py_func, source)
    return compiled
