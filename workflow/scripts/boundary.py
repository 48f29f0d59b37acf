"""What every script does around its one call: threads, log and progress, and one line where the input is bad."""

import importlib
import os
import sys
import traceback
from contextlib import contextmanager, redirect_stderr


class TerminalAndLog:
    """Write standard error to the terminal and to the log. Progress bars go to the log line by line."""

    def __init__(self, terminal, log):
        self.terminal, self.log = terminal, log

    def write(self, text):
        is_progress = text.startswith("\r")
        if not is_progress or self.terminal.isatty():
            self.terminal.write(text)
        self.log.write(f"{text.strip()}\n" if is_progress and text.strip() else text.lstrip("\r"))
        return len(text)

    def flush(self):
        self.terminal.flush()
        self.log.flush()

    def isatty(self):
        return True


@contextmanager
def job(snakemake):
    """Run the body of a script as a job of Snakemake; on any error exit with status 1."""
    os.environ["NUMBA_NUM_THREADS"] = str(snakemake.threads)
    from rockdamp.errors import InputError, warnings_as_lines
    from rockdamp.storage.dataset import DatasetError

    with open(snakemake.log[0], "w", encoding="utf-8", buffering=1) as log:
        with redirect_stderr(TerminalAndLog(sys.stderr, log)):
            try:
                with warnings_as_lines():
                    yield
                require_unchanged_sources(snakemake)
            except (InputError, DatasetError, OSError) as error:  # the last: a full disk, a folder that is read-only
                print(f"{snakemake.rule}: {error}", file=sys.stderr)
                sys.exit(1)
            except Exception:
                traceback.print_exc()
                sys.exit(1)


def require_unchanged_sources(snakemake):
    """Raise `InputError` if the sources were edited during the run: then Snakemake deletes what the job wrote."""
    from rockdamp.errors import InputError
    from rockdamp.storage.provenance import edited_since

    began = float(os.environ.get("ROCKDAMP_RUN_BEGAN", 0))
    now = snakemake.params.sources.version() if edited_since(began) else snakemake.params.version
    if now != snakemake.params.version:
        were = f"they were {snakemake.params.version} when this run began"
        raise InputError(f"the sources are {now}, and {were}; leave them alone while it runs, and run again")


def open_datasets(snakemake):
    """Return the datasets that a job reads, in their order."""
    return [open_dataset(snakemake, path) for path in snakemake.input.datasets]


def open_dataset(snakemake, path):
    """Return a dataset that a job reads; it must state the config and the code of this run."""
    from rockdamp.storage import dataset

    opened = dataset.open(path)
    dataset.require_attributes(opened, path, snakemake.params.attributes[path])
    return opened


@contextmanager
def records_named(records):
    """Name the record in an error of the input."""
    from rockdamp.errors import InputError

    try:
        yield
    except InputError as error:
        raise InputError(": ".join([*records, str(error)])) from error


def call(function, *arguments, **named):
    """Call a function by its full name."""
    module, _, name = function.rpartition(".")
    return getattr(importlib.import_module(module), name)(*arguments, **named)
