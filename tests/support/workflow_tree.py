"""A copy of the repository in which snakemake runs, whatever surrounds the tests."""

import hashlib
import os
import re
import shutil
import subprocess
import sys

from repository import ROOT

NOT_COPIED = (".*", "results", "logs", "build", "dist")


class Tree:
    """A copy of the repository in which snakemake runs."""

    def __init__(self, place):
        if not place.exists():
            shutil.copytree(ROOT, place, ignore=shutil.ignore_patterns(*NOT_COPIED))
        self.place = place
        # The package of the copy, not the installed one; tests run there remove nothing of other runs.
        set_here = {
            "PYTHONPATH": str(place / "src"),
            "PYTHONUTF8": "1",
            "PYTEST_DEBUG_TEMPROOT": str(place.parent),
        }
        dropped = re.compile("SNAKEMAKE_PROFILE|NUMBA_.*|SOURCE_DATE_EPOCH|COVERAGE_PROCESS_START")
        self.environment = {
            key: value for key, value in os.environ.items() if not dropped.fullmatch(key)
        } | set_here

    def snakemake(self, *arguments, overlay=None):
        """Run it on the minimal config, with more keys from `overlay` where that is given."""
        files = ["config/minimal.yaml"]
        if overlay is not None:
            (self.place / "overlay.yaml").write_text(overlay, encoding="utf-8")
            files.append("overlay.yaml")
        run = ["-m", "snakemake", "--cores", "2", "--nocolor", *arguments, "--configfile", *files]
        command = [sys.executable, *run]
        return subprocess.run(
            command, cwd=self.place, env=self.environment, capture_output=True, text=True
        )

    def jobs(self, run):
        """Jobs that a dry run lists: rules with the number of their jobs, without targets."""
        text = run.stdout + run.stderr
        assert run.returncode == 0, text
        table = text.partition("Job stats:")[2].partition("total")[0]
        jobs = {
            name: int(count)
            for name, count in re.findall(r"^(\w+) +(\d+)$", table, flags=re.MULTILINE)
        }
        return {name: count for name, count in jobs.items() if name != "all"}

    def digests(self, folder="results"):
        files = sorted(path for path in (self.place / folder).rglob("*") if path.is_file())
        return {
            str(path.relative_to(self.place)): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in files
        }
