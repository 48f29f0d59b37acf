"""A copy of the repository in which Snakemake runs, whatever surrounds the tests."""

import hashlib
import os
import re
import shutil
import subprocess
import sys

from repository import ROOT

NOT_COPIED = (".*", "results", "logs", "build", "dist")
# Variables of the machine that would change a run.
UNSET = re.compile("SNAKEMAKE_PROFILE|NUMBA_.*|SOURCE_DATE_EPOCH|COVERAGE_PROCESS_START")


class Tree:
    """A copy of the repository at `place`, or the one that is there."""

    def __init__(self, place):
        if not place.exists():
            shutil.copytree(ROOT, place, ignore=shutil.ignore_patterns(*NOT_COPIED))
        self.place = place
        environment = {key: value for key, value in os.environ.items() if not UNSET.fullmatch(key)}
        # Tests that run in the copy remove nothing elsewhere.
        self.environment = environment | {
            "PYTHONUTF8": "1",
            "PYTEST_DEBUG_TEMPROOT": str(place.parent),
        }
        self.use_package(ROOT)

    def use_package(self, place):
        """Run the package of a folder: the repository's is compiled, that of a copy is not."""
        self.environment["PYTHONPATH"] = str(place / "src")

    def snakemake(self, *arguments, overlay=None):
        """Run Snakemake on the minimal config; a text `overlay` changes its keys."""
        files = ["config/minimal.yaml"]
        if overlay is not None:
            (self.place / "overlay.yaml").write_text(overlay, encoding="utf-8")
            files.append("overlay.yaml")
        program = [sys.executable, "-m", "snakemake", "--cores", "2", "--nocolor"]
        command = [*program, *arguments, "--configfile", *files]
        return subprocess.run(
            command, cwd=self.place, env=self.environment, capture_output=True, text=True
        )

    def jobs(self, process):
        """Return the jobs that a dry run lists: rules with their number of jobs, without `all`."""
        text = process.stdout + process.stderr
        assert process.returncode == 0, text
        table = text.partition("Job stats:")[2].partition("total")[0]
        rows = re.findall(r"^(\w+) +(\d+)$", table, flags=re.MULTILINE)
        return {name: int(count) for name, count in rows if name != "all"}

    def digests(self, folder="results"):
        """Return the digest of every file of a folder, by its path in the tree."""
        digests = {}
        for path in sorted((self.place / folder).rglob("*")):
            if path.is_file():
                name = str(path.relative_to(self.place))
                digests[name] = hashlib.sha256(path.read_bytes()).hexdigest()
        return digests
