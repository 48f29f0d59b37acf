"""What every job does around its one call: threads, log and progress, and one clear line where the input is bad."""

import os
import sys
import traceback
from contextlib import contextmanager


class _Both:
    """Standard error and the log at once. The log shows progress too, line by line; without a terminal only the log."""

    def __init__(self, terminal, log):
        self.terminal, self.log = terminal, log

    def write(self, text):
        bar = text.startswith("\r")
        if not bar or self.terminal.isatty():
            self.terminal.write(text)
        if not bar:
            self.log.write(text)
        elif text.strip():
            self.log.write(text.strip() + "\n")
        return len(text)

    def flush(self):
        self.terminal.flush()
        self.log.flush()

    def isatty(self):
        return True


@contextmanager
def job(snakemake):
    """Run the body of a script as the job that `snakemake` describes; on any error exit with status 1.

    The body is given the job's `Inputs`, which open datasets.
    """
    os.environ["NUMBA_NUM_THREADS"] = str(snakemake.threads)
    sys.modules.setdefault("pint", None)  # no array here has units; xarray would import it at each file to see so
    from rockdamp.process import collect_rarely

    collect_rarely()  # before the imports that make the most objects
    from rockdamp.errors import InputError, warnings_as_lines
    from rockdamp.storage.dataset import DatasetError

    with open(snakemake.log[0], "w", encoding="utf-8", buffering=1) as log:
        sys.stderr = _Both(sys.__stderr__, log)
        try:
            with warnings_as_lines():
                require_unchanged(snakemake)
                inputs = Inputs(snakemake)
                yield inputs
                require_unchanged(snakemake)
                inputs.note()
        except (InputError, DatasetError, OSError) as error:  # the last: a full disk, a folder that is read-only
            print(f"{snakemake.rule}: {error}", file=sys.stderr)
            sys.exit(1)
        except Exception:
            traceback.print_exc()
            sys.exit(1)
        finally:
            sys.stderr = sys.__stderr__


def require_unchanged(snakemake):
    """Stop unless the sources are those whose version the result states; it was taken when the workflow was read.

    Asked before they are imported and after all is done. On an error Snakemake deletes what was written.
    """
    from pathlib import Path

    from rockdamp.errors import InputError
    from rockdamp.storage.provenance import version_of

    stated, now = snakemake.params.version, version_of(Path(path).resolve() for path in snakemake.input.code)
    if now != stated:
        raise InputError(
            f"the sources are {now}, and {stated} when this run began; leave them alone while it runs, and run again"
        )


class Inputs:
    """What a job reads: results of other jobs, which must be what their rules wrote in this tree, and sources."""

    def __init__(self, snakemake):
        from rockdamp.pipeline.soundness import expectations
        from rockdamp.storage import notes

        self.snakemake, self.results = snakemake, snakemake.config["results"]
        self.expected, self.name = expectations(snakemake.input.state, snakemake.config)
        unread = {*snakemake.input.code, snakemake.input.state}
        self.digests = {path: notes.digest(path) for path in snakemake.input if path not in unread}
        for path in self.digests:
            self._require_written(path)

    def _require_written(self, path):
        from rockdamp.storage import notes
        from rockdamp.storage.dataset import DatasetError

        inside = notes.inside(self.results, path)
        if inside in self.expected:
            note = notes.read(self.results, self.expected[inside].name)
            if note.get("files", {}).get(inside) != self.digests[path]:
                raise DatasetError(f"{path} is not what its rule wrote, by its digest; delete it and run again")

    def open(self, path, lazily=False):
        """Open a dataset, which must be of the config and the sources of this run."""
        from rockdamp.storage import dataset, notes

        opened = (dataset.connect if lazily else dataset.open)(path)
        wanted = self.expected[notes.inside(self.results, path)]
        given = {"config_sha256": wanted.config_sha256, "code_version": wanted.code_version}
        dataset.require_stated(opened, path, wanted.kind, **given)
        return opened

    def note(self):
        """Write down what the job made, and of what."""
        from rockdamp.storage import notes
        from rockdamp.storage.provenance import config_digest

        notes.write(
            self.results,
            self.name,
            code_version=self.snakemake.params.version,
            config_sha256=config_digest(getattr(self.snakemake.params, "config", {})),
            files=self.snakemake.output,
            inputs=self.digests,
        )


@contextmanager
def about(records, datasets):
    """Name the record in an error of the input, and the dataset in one of reading its values late."""
    from rockdamp.errors import InputError
    from rockdamp.storage import dataset

    try:
        yield
    except InputError as error:
        raise InputError(": ".join([*records, str(error)])) from error
    except RuntimeError:
        for path in datasets:
            dataset.open(path)  # raises where this is the one that cannot be read
        raise


def call(function, *arguments):
    """Call a function by its full name."""
    module, _, name = function.rpartition(".")
    __import__(module)
    return getattr(sys.modules[module], name)(*arguments)
