"""Break one equation at a time and see that the suite notices.

    .venv/bin/python tools/mutate.py [--jobs 2] [NAME ...]
    .venv/bin/python tools/mutate.py --missing

Run by hand, some minutes. The mutations stand in mutations.yaml. Each is made in a copy of the package, against which
the tests named with it run until one fails. That one must pass against the same copy without the mutation: a test that
cannot live outside the tree notices nothing. The last line counts; the exit status is 1 if any mutation survives, or no
longer finds the text that it changes. `--missing` lists the modules with a function that no mutation changes.
"""

from __future__ import annotations

import argparse
import ast
import os
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue
from typing import NamedTuple

import yaml

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src/rockdamp"
SURVIVED, STATUS = "**survived**", "exit status"
PYTEST = [sys.executable, *"-m pytest -x -q --no-header -p no:cacheprovider --tb=no -m".split(), "not peers"]


class Mutation(NamedTuple):
    """One wrong equation, and the tests that should notice first."""

    name: str
    file: str
    right: str
    wrong: str
    tests: list[str]


class Copy:
    """A copy of the package, in which one file at a time is wrong; what is compiled of the others is kept."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.source = folder, folder / "src"
        shutil.copytree(ROOT / "src", self.source, ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))

    def test(self, mutation: Mutation) -> str:
        """Return the first test that fails, or what to say of a mutation that survives, in bold."""
        path = self.source / "rockdamp" / mutation.file
        text = path.read_text(encoding="utf-8")
        # Numba's cache does not notice every edit of what it compiled.
        cache = self.folder / ("mutated" if "numba" in text else "cache")
        path.write_text(text.replace(mutation.right, mutation.wrong), encoding="utf-8")
        try:
            failed = self.first_failure(mutation.tests, cache)
        finally:
            shutil.copy2(ROOT / "src/rockdamp" / mutation.file, path)
            shutil.rmtree(self.folder / "mutated", ignore_errors=True)
        if not failed or failed.startswith(STATUS):
            return failed or SURVIVED
        test = failed.partition("[")[0]  # with all of its parameters: some hold what divides the lines of pytest
        if self.first_failure([test], self.folder / "cache"):
            return f"**{test} fails without it too**"
        return failed.partition("::")[2] or failed

    def first_failure(self, tests: list[str], cache: Path) -> str:
        """Return the first test that fails against the copy as it is, below `tests`; empty if none does."""
        changes = {"PYTHONPATH": str(self.source), "NUMBA_CACHE_DIR": str(cache)}
        command = [*PYTEST, *(str(ROOT / "tests" / name) for name in tests)]
        run = subprocess.run(command, cwd=ROOT, env={**os.environ, **changes}, capture_output=True, text=True)
        if run.returncode == 0:
            return ""
        failed = [line.split(" ", 1)[1] for line in run.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
        return failed[0].split(" - ")[0].removeprefix("tests/") if failed else f"{STATUS} {run.returncode}"


def missing(mutations: list[Mutation]) -> list[str]:
    """Return the modules that no mutation changes, but those that hold names, numbers or fields alone."""
    unchanged = {path.relative_to(PACKAGE).as_posix(): path for path in sorted(PACKAGE.rglob("*.py"))}
    for mutation in mutations:
        unchanged.pop(mutation.file, None)
    trees = {name: ast.parse(path.read_text(encoding="utf-8")) for name, path in unchanged.items()}
    return [
        name
        for name, tree in trees.items()
        if any(isinstance(node, ast.FunctionDef | ast.Lambda) for node in ast.walk(tree))
    ]


def main() -> int:
    """Run the mutations whose names contain one of the arguments, or all."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("names", nargs="*", metavar="NAME", help="a part of a mutation's name")
    options.add_argument("--jobs", type=int, default=2, help="mutations at once")
    options.add_argument("--missing", action="store_true", help="list the modules without a mutation, and run none")
    given = options.parse_args()
    entries = yaml.safe_load(Path(__file__).with_name("mutations.yaml").read_text(encoding="utf-8"))
    listed = [Mutation(**entry) for entry in entries]
    if given.missing:
        print("\n".join(missing(listed)))
        return 0
    chosen = [m for m in listed if not given.names or any(word in m.name for word in given.names)]
    for mutation in chosen:
        if mutation.right not in (ROOT / "src/rockdamp" / mutation.file).read_text(encoding="utf-8"):
            sys.exit(f"{mutation.name}: {mutation.file} does not hold {mutation.right!r} any more")
    survivors = 0
    print("| mutation | file | noticed by | s |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(given.jobs) as pool:
        copies: SimpleQueue[Copy] = SimpleQueue()
        for number in range(given.jobs):
            copies.put(Copy(Path(folder, str(number))))

        def run(mutation: Mutation) -> tuple[str, float]:
            start, copy = time.perf_counter(), copies.get()
            try:
                return copy.test(mutation), time.perf_counter() - start
            finally:
                copies.put(copy)

        for mutation, (noticed, seconds) in zip(chosen, pool.map(run, chosen), strict=True):
            survivors += noticed.startswith("**")
            print(f"| {mutation.name} | {mutation.file} | {noticed} | {seconds:.0f} |", flush=True)
    print(f"{len(chosen) - survivors} of {len(chosen)} noticed")
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
