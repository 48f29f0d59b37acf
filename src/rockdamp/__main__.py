"""Start the command line, as `rockdamp` and as `python -m rockdamp`.

What must hold from the first moment on is set here, before the command line is imported: Ctrl-C ends the process, and
files that are opened get no number of a standard stream.
"""

from __future__ import annotations

import os
import signal
from contextlib import suppress


def main() -> None:
    """Run the command line with the arguments of the process."""
    _open_streams()
    interruptible = signal.getsignal(signal.SIGINT) is signal.default_int_handler  # not under nohup
    if interruptible:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # while nothing is written
    from rockdamp.cli import main as command

    def end(number: int, _: object) -> None:
        """End the process by the signal: a KeyboardInterrupt is lost in an import or where an object is deleted."""
        with suppress(OSError):
            os.write(2, b"Aborted!\n")
        signal.signal(number, signal.SIG_DFL)
        signal.raise_signal(number)

    if interruptible:
        signal.signal(signal.SIGINT, end)
    if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
        signal.signal(signal.SIGTERM, end)
    command(prog_name="rockdamp")


def _open_streams() -> None:
    """Open what the shell closed (`2>&-`) on nothing: a file of results would become standard error."""
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free


if __name__ == "__main__":
    main()
