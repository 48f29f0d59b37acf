"""Read files that others wrote: once and whole, without waiting for them, and only text; and split CSV lines.

Tables have commas, semicolons or tabs, and decimal commas beside the last two.
"""

from __future__ import annotations

import os
import re
import stat

from rockdamp.errors import InputError

MOST_BYTES = 2**28  # of one file: over a day of ground motion at 200 Hz
STREAMS = ("/dev/stdin", "/dev/fd/", "/proc/self/fd/")  # what a shell calls a pipe that it made
# Windows has the first of these flags alone, and other systems the second and third.
BINARY = getattr(os, "O_BINARY", 0)
AT_ONCE = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0)
_CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")  # all but tab and line feed


def content(path: str | os.PathLike[str], what: str) -> bytes:
    """Return the bytes of a regular file or of a stream, which gives them once only.

    `what` it must be goes into errors: ``a record as CSV or PEER AT2``. A folder, a device, more than `MOST_BYTES`, and
    a named pipe, which may have nobody who writes to it, raise `InputError`.
    """
    shown, allowed = os.fspath(path), f"it must be {what}"
    try:
        descriptor = os.open(path, os.O_RDONLY | BINARY | AT_ONCE)  # opening a named pipe would block
        try:
            kind = os.fstat(descriptor).st_mode
            if stat.S_ISDIR(kind):
                raise InputError(f"{shown}: is a directory; {allowed}")
            if not (stat.S_ISREG(kind) or shown.startswith(STREAMS)):
                raise InputError(f"{shown}: is neither a regular file nor a stream such as /dev/stdin; {allowed}")
            if AT_ONCE:
                os.set_blocking(descriptor, True)
            with os.fdopen(descriptor, "rb", closefd=False) as file:
                read = file.read(MOST_BYTES + 1)
        finally:
            os.close(descriptor)
    except FileNotFoundError:
        raise InputError(f"{shown}: there is no such file; {allowed}") from None
    except OSError as error:
        raise InputError(f"{shown}: cannot be read ({error.strerror})") from None
    except InputError:
        raise
    except ValueError as error:  # a null in its name
        raise InputError(f"{shown!r}: is no name of a file ({error}); {allowed}") from None
    if len(read) > MOST_BYTES:
        raise InputError(f"{shown}: has more than {MOST_BYTES} bytes; {allowed}")
    return read


def text(read: bytes, path: str | os.PathLike[str]) -> str:
    """Decode UTF-8 as text with one kind of line end; other bytes and control characters raise `InputError`."""
    if read.startswith((b"PK\x03\x04", b"\xd0\xcf\x11\xe0")):
        raise InputError(f"{os.fspath(path)}: is a workbook or an archive; it must be text: save it as CSV")
    try:
        decoded = read.decode("utf-8-sig")  # spreadsheets put a byte order mark first
    except UnicodeDecodeError as error:
        line = read.count(b"\n", 0, error.start) + 1
        shown = f"{os.fspath(path)}: byte 0x{read[error.start]:02x} on line {line}"
        raise InputError(f"{shown} is not text; it must be UTF-8") from None
    decoded = decoded.replace("\r\n", "\n").replace("\r", "\n")
    odd = _CONTROL.search(decoded)
    if odd is not None:
        line, code = decoded.count("\n", 0, odd.start()) + 1, ord(odd[0])
        raise InputError(
            f"{os.fspath(path)}: character 0x{code:02x} on line {line} is a control character; it must be text in UTF-8"
        )
    return decoded


# --- lines of tables -------------------------------------------------------------------------------------------------

DIVIDERS = (";", "\t", ",")
_DECIMAL_COMMA = re.compile(r"\s*[-+]?\d*,\d+(?:[eE][-+]?\d+)?\s*")


def divider(line: str) -> str | None:
    """Return what divides the cells of a line; None for blanks."""
    return next((mark for mark in DIVIDERS if mark in line), None)


def with_point(cell: str, divided_by: str | None) -> str:
    """Return a cell with a decimal point, where commas do not divide the cells and it has a decimal comma."""
    return cell.replace(",", ".") if divided_by != "," and _DECIMAL_COMMA.fullmatch(cell) else cell


def with_commas(line: str, divided_by: str | None) -> str:
    """Return a line without quotes as one that commas divide; its numbers get decimal points."""
    if divided_by in (",", None):
        return line
    return ",".join(with_point(cell, divided_by) for cell in line.rstrip(f"{divided_by} ").split(divided_by))
