"""Write files that appear whole or not at all, and stay if the machine stops."""

from __future__ import annotations

import os
import re
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

LONGEST = 60  # letters of the file's name in that of the temporary one, lest that be too long
TEMPORARY = re.compile(r"\..+\.[0-9a-f]{16}\.part", flags=re.DOTALL)
NO_LINK = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_CLOEXEC", 0)  # Windows has neither
WRITING: set[Path] = set()  # temporary files of this process


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path beside `path`; what is written there takes its place at the end, if nothing failed.

    The temporary name cannot be guessed and is made new, so that two that write the same file, processes or threads, do
    not meet, and no link is followed. Permissions of a file that is replaced stay. A process that is killed leaves the
    temporary file behind; nothing reads it, and `tidy` deletes it. An `OSError`, as of a full disk, names the file.
    """
    path = Path(path)
    temporary = path.with_name(f".{path.name[:LONGEST]}.{secrets.token_hex(8)}.part")
    WRITING.add(temporary)
    try:
        os.close(os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL | NO_LINK, 0o666))
        yield temporary
        _keep_permissions(path, temporary)
        _to_disk(temporary)
        os.replace(temporary, path)
        with suppress(OSError):  # some file systems have no such request for a folder
            _to_disk(path.parent)
    except OSError as error:
        error.filename = error.filename or str(path)  # a write that fails does not say where
        raise
    finally:
        with suppress(OSError):  # moved, never made, or on a disk that has become read-only: the first error counts
            temporary.unlink()
        WRITING.discard(temporary)


def tidy(folder: str | os.PathLike[str]) -> None:
    """Delete the temporary files that killed processes left in a folder, where no other process is writing."""
    for path in Path(folder).glob(".*.part"):
        if TEMPORARY.fullmatch(path.name):
            path.unlink(missing_ok=True)


def _keep_permissions(path: Path, temporary: Path) -> None:
    try:
        earlier = os.lstat(path).st_mode
    except FileNotFoundError:
        return
    if stat.S_ISREG(earlier):
        os.chmod(temporary, stat.S_IMODE(earlier))


def _to_disk(path: Path) -> None:
    descriptor = os.open(path, os.O_RDWR if os.name == "nt" else os.O_RDONLY | NO_LINK)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
