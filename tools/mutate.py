"""Break one equation at a time and see that the suite notices: `.venv/bin/python tools/mutate.py [NAME ...]`.

Run by hand. The mutations stand in mutations.yaml. Each is made in a copy of the package, against which the tests named
with it run until one fails.
The last line counts; the exit status is 1 if any mutation survives, or no longer finds the text that it changes.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import yaml

ROOT = Path(__file__).resolve().parents[1]


class Mutation(NamedTuple):
    """One wrong equation, and the tests that should notice first."""

    name: str
    file: str
    right: str
    wrong: str
    tests: list[str]


MUTATIONS = [
    Mutation(**entry) for entry in yaml.safe_load(Path(__file__).with_name("mutations.yaml").read_text("utf-8"))
]


def run(mutation: Mutation, folder: Path) -> str:
    """Return the first failing test, or an empty string where the mutation survives."""
    source = folder / "src"
    shutil.rmtree(source, ignore_errors=True)
    shutil.copytree(ROOT / "src", source, ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))
    path = source / "rockdamp" / mutation.file
    text = path.read_text(encoding="utf-8")
    if text.count(mutation.right) < 1:
        raise SystemExit(f"{mutation.name}: {mutation.file} does not hold {mutation.right!r} any more")
    path.write_text(text.replace(mutation.right, mutation.wrong), encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": str(source), "NUMBA_CACHE_DIR": str(folder / "cache")}
    tests = [str(ROOT / "tests" / name) for name in mutation.tests]
    command = [sys.executable, "-m", "pytest", "-x", "-q", "--no-header", "-p", "no:cacheprovider", "--tb=no", *tests]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    shutil.rmtree(folder / "cache", ignore_errors=True)
    if done.returncode == 0:
        return ""
    failed = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return failed[0].split(" - ")[0].split("::", 1)[-1] if failed else f"exit status {done.returncode}"


def main() -> int:
    """Run the mutations whose names contain one of the arguments, or all."""
    chosen = [m for m in MUTATIONS if not sys.argv[1:] or any(word in m.name for word in sys.argv[1:])]
    survivors = 0
    print("| mutation | file | noticed by | s |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for mutation in chosen:
            start = time.perf_counter()
            noticed = run(mutation, Path(folder))
            survivors += not noticed
            seconds = time.perf_counter() - start
            print(f"| {mutation.name} | {mutation.file} | {noticed or '**survived**'} | {seconds:.0f} |", flush=True)
    print(f"{len(chosen) - survivors} of {len(chosen)} noticed")
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
