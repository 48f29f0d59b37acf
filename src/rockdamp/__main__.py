"""Start the command line, as `rockdamp` and as `python -m rockdamp`.

What must hold from the first moment on is set here, before the command line is imported: Ctrl-C ends the process, and
files that are opened get no number of a standard stream.
"""

from __future__ import annotations

import os
import signal
import sys
from contextlib import suppress
from types import FrameType

INTERRUPTED = 130  # exit status by Ctrl-C, as shells count it


def main() -> None:
    """Run the command line with the arguments of the process."""
    _open_streams()
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # not under nohup
        signal.signal(signal.SIGINT, _end)
    from rockdamp.cli import main as command

    command(prog_name="rockdamp")


def _open_streams() -> None:
    """Open what the shell closed (`2>&-`) on nothing: a file of results would become standard error."""
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free


def _end(signal_number: int, frame: FrameType | None) -> None:
    """End the process at once. A KeyboardInterrupt is lost where a module is imported or an object is deleted."""
    atomic = sys.modules.get("rockdamp.storage.atomic")
    for path in [*atomic.WRITING] if atomic else ():
        with suppress(OSError):
            path.unlink()
    with suppress(OSError):
        os.write(2, b"Aborted!\n")
    os._exit(INTERRUPTED)


if __name__ == "__main__":
    main()
