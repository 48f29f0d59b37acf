"""A copy of the repository in which programs run by hand build the minimal config."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
RESULTS = "results/minimal"
NOT_COPIED = (".*", "results", "logs", "__pycache__", "build", "dist", "htmlcov")


class Tree:
    """A copy of the repository in which snakemake runs on the minimal config."""

    def __init__(self, place: Path) -> None:
        self.place, self.results = place, place / RESULTS
        shutil.copytree(ROOT, place, ignore=shutil.ignore_patterns(*NOT_COPIED))
        dropped = ("SNAKEMAKE_PROFILE", "NUMBA_CACHE_DIR", "NUMBA_DISABLE_JIT", "SOURCE_DATE_EPOCH", "PYTHONUTF8")
        kept = {key: value for key, value in os.environ.items() if key not in dropped}
        self.environment = {**kept, "PYTHONPATH": str(place / "src")}  # the package of the copy
        self.command = [sys.executable, "-m", "snakemake", "--cores", "2", "--nocolor"]
        self.command += ["--configfile", "config/minimal.yaml"]
        self.whole: dict[str, str] = {}  # digests of an undisturbed build
        self.seconds = 0.0  # that it took

    def run(self, *arguments: str, **changes: str | None) -> subprocess.CompletedProcess[str]:
        """Run snakemake to its end; `changes` of the environment, None to take a variable away."""
        return self.call([*self.command, "--", *arguments] if arguments else self.command, **changes)

    def call(self, command: list[str], **changes: str | None) -> subprocess.CompletedProcess[str]:
        environment = {key: value for key, value in {**self.environment, **changes}.items() if value is not None}
        return subprocess.run(
            command, cwd=self.place, env=environment, capture_output=True, text=True, errors="replace"
        )

    def start(self) -> subprocess.Popen[bytes]:
        """Start snakemake in a process group of its own."""
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        return subprocess.Popen(self.command, cwd=self.place, env=self.environment, start_new_session=True, **quiet)

    def digests(self) -> dict[str, str]:
        """Of every result under its own name; what a killed job left unfinished is hidden."""
        files = [path for path in self.results.rglob("*") if path.is_file() and not path.name.endswith(".part")]
        return {str(path.relative_to(self.results)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}

    def differences(self) -> list[str]:
        """Results that are not those of the undisturbed build, or are missing."""
        now = self.digests()
        return sorted(name for name in {*now, *self.whole} if now.get(name) != self.whole.get(name))

    def truncated(self) -> list[str]:
        """Results that stand there with other bytes than the undisturbed build's."""
        return sorted(name for name, digest in self.digests().items() if self.whole.get(name) != digest)

    def clear(self) -> None:
        """Forget the build, but keep what numba compiled."""
        shutil.rmtree(self.results, ignore_errors=True)
        for name in ("metadata", "incomplete", "locks"):
            shutil.rmtree(self.place / ".snakemake" / name, ignore_errors=True)

    def locked(self) -> bool:
        return any((self.place / ".snakemake/locks").glob("*"))


def last_lines(run: subprocess.CompletedProcess[str]) -> str:
    return " / ".join((run.stdout + run.stderr).strip().splitlines()[-3:])[-200:]


def line_with(run: subprocess.CompletedProcess[str], *words: str) -> str:
    """The first line that has all of these words, or an empty string."""
    found = [line for line in (run.stdout + run.stderr).splitlines() if all(word in line for word in words)]
    return found[0].strip() if found and "Traceback" not in run.stdout + run.stderr else ""
