"""Break the science anywhere, at random, and count what the suite notices.

    .venv/bin/python tools/mutate_sample.py [--count 200] [--seed 7] [--jobs 2] [--output FILE.csv]
                                            [--since REVISION] [--near] [PACKAGE ...]

Run by hand. Mutations are made from the syntax tree: operators, comparisons, numbers, signs,
arguments and names of functions. Each place of the packages of science is as likely as any other; with --since, each
on a line that was committed since REVISION, and did not only move. A mutation is noticed if a test of the module's
folder, or of the folders that use it, fails; with --near, a test of the files that import the module or are named
after it. The sample is in a random order: what a run that was stopped has done is a sample too.
FILE gets a row for each, as it ends, and a second run with the same FILE goes on behind it. Whether a survivor changes
any value at all is judged by hand, in the column `equivalent` of FILE.
"""

from __future__ import annotations

import argparse
import ast
import csv
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from queue import SimpleQueue
from typing import Any, NamedTuple

from table_text import percent, table

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src/rockdamp"
SURVIVED, STATUS = "**survived**", "exit status"
LONGEST = 900  # s, after which tests are ended; then "exit status" stands in FILE, and is judged by hand
NEAREST = 6  # files of tests
PYTEST = [sys.executable, *"-m pytest -x -q --no-header -p no:cacheprovider --tb=no -m".split(), "not peers"]
# Packages of science, and the folders of tests that use them, nearest first.
PACKAGES = {
    "mechanics": ["mechanics", "solvers", "theory", "equivalence", "test_properties.py"],
    "solvers": ["solvers", "theory", "equivalence", "histories"],
    "equivalence": ["equivalence", "studies/test_matches.py", "studies/test_polynomial_fits.py"],
    "histories": ["histories", "assessment", "studies"],
    "laboratory": ["laboratory"],
    "statistics": ["statistics", "assessment", "studies"],
    "motions": ["motions", "assessment", "histories"],
    "assessment": ["assessment", "cli"],
    "studies": ["studies", "claims"],
    "claims": ["claims"],
}
OPERATORS: dict[type[ast.AST], tuple[str, str]] = {
    ast.Add: ("+", "-"),
    ast.Sub: ("-", "+"),
    ast.Mult: ("*", "/"),
    ast.Div: ("/", "*"),
    ast.Pow: ("**", "*"),
    ast.Mod: ("%", "//"),
    ast.FloorDiv: ("//", "%"),
    ast.Lt: ("<", "<="),
    ast.LtE: ("<=", "<"),
    ast.Gt: (">", ">="),
    ast.GtE: (">=", ">"),
    ast.Eq: ("==", "!="),
    ast.NotEq: ("!=", "=="),
    ast.And: ("and", "or"),
    ast.Or: ("or", "and"),
}
NAMES = {"min": "max", "max": "min", "sin": "cos", "cos": "sin", "exp": "expm1", "log": "log1p", "sum": "mean"}
NAMES |= {"mean": "median", "median": "mean", "argmin": "argmax", "argmax": "argmin", "any": "all", "all": "any"}
NAMES |= {"minimum": "maximum", "maximum": "minimum", "floor": "ceil", "ceil": "floor", "abs": "float", "sqrt": "abs"}
# What computes nothing: texts of errors, warnings and progress.
WORDS = {"require", "InputError", "ConfigError", "warn", "track", "dataclass", "njit", "jitable"}
FIELDS = ("file", "line", "column", "length", "right", "wrong", "noticed", "seconds", "equivalent")


class Mutation(NamedTuple):
    """One wrong place of a file, and the tests that should notice first."""

    name: str
    file: str
    right: str
    wrong: str
    tests: list[str]


class Copy:
    """A copy of the package, in which one file at a time is wrong; what is compiled of the others is kept."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.source = folder, folder / "src"
        self.passed: set[str] = set()  # tests that pass where nothing is wrong
        shutil.copytree(ROOT / "src", self.source, ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))

    def test(self, mutation: Mutation) -> str:
        """Return the first test that fails, or what to say of a mutation that survives, in bold."""
        path = self.source / "rockdamp" / mutation.file
        path.write_text(mutation.wrong, encoding="utf-8")
        try:
            failed = self.first_failure(mutation.tests)
        finally:
            shutil.copy2(ROOT / "src/rockdamp" / mutation.file, path)
        if not failed or failed.startswith(STATUS):
            return failed or SURVIVED
        test = failed.partition("[")[0]  # with all of its parameters: some hold what divides the lines of pytest
        if test not in self.passed and self.first_failure([test]):
            return f"**{test} fails without it too**"
        self.passed.add(test)
        return failed.partition("::")[2] or failed

    def first_failure(self, tests: list[str]) -> str:
        """Return the first test that fails against the copy as it is, below `tests`; empty if none does.

        The cache of compiled code notices every edit of a file with compiled entries.
        """
        changes = {"PYTHONPATH": str(self.source), "NUMBA_CACHE_DIR": str(self.folder / "cache")}
        command = [*PYTEST, *(str(ROOT / "tests" / name) for name in tests)]
        environment = {**os.environ, **changes}
        try:
            run = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=LONGEST)
        except subprocess.TimeoutExpired:
            return f"{STATUS} none after {LONGEST} s"
        if run.returncode == 0:
            return ""
        failed = [line.split(" ", 1)[1] for line in run.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
        return failed[0].split(" - ")[0].removeprefix("tests/") if failed else f"{STATUS} {run.returncode}"


class Places(ast.NodeVisitor):
    """Collect the places of a module that a mutation may change: line, column, length and the new text."""

    def __init__(self, source: str) -> None:
        self.lines = source.splitlines(keepends=True)
        self.found: list[tuple[int, int, int, str]] = []
        self.visit(ast.parse(source))

    def add(self, line: int, start: int, length: int, text: str) -> None:
        self.found.append((line, start, length, text))

    def between(self, left: ast.expr, right: ast.expr, operator: ast.AST) -> None:
        """Change the sign between two operands, if it stands between them on one line."""
        line, start = left.end_lineno, left.end_col_offset
        if type(operator) not in OPERATORS or line is None or start is None or right.lineno != line:
            return
        sign, other = OPERATORS[type(operator)]
        at = self.lines[line - 1].find(sign, start, right.col_offset)
        if at >= 0:
            self.add(line, at, len(sign), other)

    def visit_BinOp(self, node: ast.BinOp) -> None:
        self.between(node.left, node.right, node.op)
        self.generic_visit(node)

    def visit_Compare(self, node: ast.Compare) -> None:
        for left, operator, right in zip([node.left, *node.comparators], node.ops, node.comparators, strict=False):
            self.between(left, right, operator)
        self.generic_visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        for left, right in zip(node.values, node.values[1:], strict=False):
            self.between(left, right, node.op)
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        sign = {ast.USub: "-", ast.Not: "not "}.get(type(node.op))
        if sign:
            self.add(node.lineno, node.col_offset, len(sign), "")
        self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        value, end = node.value, node.end_col_offset
        if isinstance(value, bool) or not isinstance(value, int | float) or end is None:
            return
        other = value + 1 if isinstance(value, int) else 1.1 * value or 0.1
        self.add(node.lineno, node.col_offset, end - node.col_offset, repr(other))

    def visit_Call(self, node: ast.Call) -> None:
        function: Any = node.func
        name = getattr(function, "attr", getattr(function, "id", ""))
        if name in WORDS:
            return
        if name in NAMES and function.end_lineno == function.lineno:
            self.add(function.lineno, function.end_col_offset - len(name), len(name), NAMES[name])
        for first, second in zip(node.args, node.args[1:], strict=False):
            same = first.lineno == first.end_lineno == second.lineno == second.end_lineno
            if same and not isinstance(first, ast.Starred) and not isinstance(second, ast.Starred):
                line = self.lines[first.lineno - 1]
                one, two = (line[arg.col_offset : arg.end_col_offset] for arg in (first, second))
                between = line[first.end_col_offset : second.col_offset]
                self.add(first.lineno, first.col_offset, len(one + between + two), two + between + one)
        self.generic_visit(node)

    def visit_Raise(self, node: ast.Raise) -> None:
        """Leave the words of an error alone."""

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.visit(node.value)

    def visit_arguments(self, node: ast.arguments) -> None:
        for default in (*node.defaults, *node.kw_defaults):
            if default is not None:
                self.visit(default)

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        """Leave text alone."""

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        self.visit(node.args)
        for statement in node.body:
            self.visit(statement)


def mutations(packages: list[str]) -> Iterator[dict[str, Any]]:
    """Yield every mutation of some packages, in the order of their files."""
    for package in packages:
        for path in sorted((PACKAGE / package).rglob("*.py")):
            source = path.read_text(encoding="utf-8")
            if not source.isascii():  # columns of the syntax tree count bytes
                source = "".join(c if c.isascii() else "?" for c in source)
            lines = source.splitlines()
            for line, column, length, wrong in sorted(set(Places(source).found)):
                right = lines[line - 1][column : column + length]
                if right != wrong:
                    place = {"line": line, "column": column, "length": length, "right": right, "wrong": wrong}
                    yield {"file": path.relative_to(PACKAGE).as_posix(), **place}


def tests_of(file: str) -> list[str]:
    """Return the tests that should notice: the module's file, then the folders that use its package."""
    path = Path(file)
    mirror = path.parent / f"test_{path.name}"
    folders = [name for name in PACKAGES[path.parts[0]] if (ROOT / "tests" / name).exists()]
    return [mirror.as_posix()] * (ROOT / "tests" / mirror).exists() + folders


def near(file: str) -> list[str]:
    """Return the files of tests that import a module or are named after it or its folder, its own first.

    If there are none, the folder of its package.
    """
    package, _, module = file.removesuffix(".py").removesuffix("/__init__").replace("/", ".").rpartition(".")
    names = re.compile(rf"rockdamp\.{package}\.{module}\b|from rockdamp\.{package} import [^\n]*\b{module}\b")
    first, *folders = package.split(".")
    named = tuple(f"test_{name.partition('_')[0]}" for name in (module, *folders))
    found = []
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        inside = path.relative_to(ROOT / "tests").as_posix()
        if (inside.startswith(f"{first}/") and path.stem.startswith(named)) or names.search(path.read_text("utf-8")):
            found.append(inside)
    found.sort(key=lambda inside: not inside.endswith(f"/test_{module}.py"))
    return found[:NEAREST] or [first]


def changed(since: str) -> Callable[[dict[str, Any]], bool]:
    """Return whether the line of a mutation changed since a revision; what moved between files did not."""

    @cache
    def lines(file: str) -> list[bool]:
        command = ["git", "blame", "-s", "-M", "-C", "-C", f"{since}..", "--", str(PACKAGE / file)]
        told = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
        return [not line.startswith("^") for line in told.splitlines()]

    return lambda entry: lines(entry["file"])[entry["line"] - 1]


def as_mutation(entry: dict[str, Any], tests: Callable[[str], list[str]] = tests_of) -> Mutation:
    """Return a mutation: the whole file before and after, and its tests."""
    right = (PACKAGE / entry["file"]).read_text(encoding="utf-8")
    lines = right.splitlines(keepends=True)
    line, at = lines[int(entry["line"]) - 1], int(entry["column"])
    lines[int(entry["line"]) - 1] = line[:at] + entry["wrong"] + line[at + int(entry["length"]) :]
    return Mutation(f"{entry['file']}:{entry['line']}", entry["file"], right, "".join(lines), tests(entry["file"]))


def summary(path: Path) -> str:
    """Return how many of the mutations that change a value were noticed, by package, as text and a table."""
    with path.open(newline="", encoding="utf-8") as sample:
        every = list(csv.DictReader(sample))
    rows = [row for row in every if not row["equivalent"]]
    counted = []
    for package in (*sorted({Path(row["file"]).parts[0] for row in rows}), "all"):
        those = [row for row in rows if package in ("all", Path(row["file"]).parts[0])]
        noticed = sum(row["noticed"] != SURVIVED for row in those)
        if those:
            counted.append([package, str(len(those)), str(noticed), percent(noticed / len(those))])
    head = ["package", "change a value", "noticed", "share"]
    same = len(every) - len(rows)
    return f"Of {len(every)} mutations {same} change no value beyond its stated error.\n\n{table(head, counted)}"


def main() -> int:
    """Run a sample."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("packages", nargs="*", metavar="PACKAGE", help=f"of {', '.join(PACKAGES)} (default: all)")
    options.add_argument("--count", type=int, default=200, help="mutations in the sample")
    options.add_argument("--seed", type=int, default=7, help="of the sample")
    options.add_argument("--jobs", type=int, default=2, help="mutations at once")
    options.add_argument("--output", type=Path, default=Path("mutations.csv"), help="table of what came out")
    options.add_argument("--since", metavar="REVISION", help="mutate only lines that changed since")
    options.add_argument("--near", action="store_true", help="run only the files of tests that import the module")
    asked = options.parse_args()
    every = list(mutations(asked.packages or list(PACKAGES)))
    every = list(filter(changed(asked.since), every)) if asked.since else every
    sample = random.Random(asked.seed).sample(every, min(asked.count, len(every)))
    done = 0
    if asked.output.exists():
        with asked.output.open(newline="", encoding="utf-8") as table:
            done = sum(1 for _ in csv.DictReader(table))
    with (
        asked.output.open("a", newline="", encoding="utf-8") as table,
        tempfile.TemporaryDirectory() as folder,
        ThreadPoolExecutor(asked.jobs) as pool,
    ):
        rows = csv.DictWriter(table, FIELDS, lineterminator="\n")
        if not done:
            rows.writeheader()
        copies: SimpleQueue[Copy] = SimpleQueue()
        for number in range(asked.jobs):
            copies.put(Copy(Path(folder, str(number))))

        def run(entry: dict[str, Any]) -> dict[str, Any]:
            start, copy = time.perf_counter(), copies.get()
            try:
                noticed = copy.test(as_mutation(entry, near if asked.near else tests_of))
            finally:
                copies.put(copy)
            return {**entry, "noticed": noticed, "seconds": f"{time.perf_counter() - start:.0f}"}

        for count, row in enumerate(pool.map(run, sample[done:]), start=done + 1):
            rows.writerow(row)
            table.flush()
            print(f"{count}/{len(sample)} {row['file']}:{row['line']}: {row['noticed']}", flush=True)
    print(summary(asked.output))
    return 0


if __name__ == "__main__":
    sys.exit(main())
