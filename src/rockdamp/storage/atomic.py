"""Files that appear whole or not at all."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path beside `path`; what is written there takes its place at the end, if nothing failed.

    The name holds the machine and the process, so that two that write the same file do not meet. A process that is
    killed leaves the temporary file behind; nothing reads it.

    Raises
    ------
    OSError
        If the file cannot be written or moved, as where the disk is full or its folder is missing. It names a file.
    """
    path = Path(path)
    temporary = path.with_name(f".{path.name}.{platform.node()}.{os.getpid()}.part")
    try:
        yield temporary
        os.replace(temporary, path)
    except OSError as error:
        error.filename = error.filename or str(path)  # a write that fails does not say where
        raise
    finally:
        with suppress(OSError):  # moved, never made, or on a disk that has become read-only: the first error counts
            temporary.unlink()
