"""Break the science at random places, and count the mutations that the tests notice.

    .venv/bin/python tools/mutate_sample.py FILE.csv [--count 150] [--seed 51] [--package NAME ...]

A mutation changes an operator, a comparison, a number, a sign, the order of two arguments or the
name of a function. Each place of the packages is as likely as any other. A mutation is noticed if a
test fails in one of the files that import the module or are named after it. The first run writes
the sample to FILE, and each run adds the outcomes row by row: a second run continues where the
first one stopped. --package runs the rows of some packages only. If the code at a place was edited
since, another place of its package is drawn. Whether a survivor changes a value is judged by hand,
in the column `equivalent`.
"""

from __future__ import annotations

import argparse
import ast
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src/rockdamp"
TESTS = ROOT / "tests"
PACKAGES = (
    "mechanics",
    "solvers",
    "equivalence",
    "histories",
    "statistics",
    "assessment",
    "studies",
    "motions",
)
SURVIVED = "**survived**"
PYTEST = [sys.executable, "-m", "pytest", "-x", "-q", "--no-header", "--tb=no"]
PYTEST += ["-p", "no:cacheprovider", "-m", "not peers"]
MOST_FILES = 6  # of tests that run for a mutation
MOST_SECONDS = 600  # of these tests: a mutation may cause an endless loop
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
    ast.USub: ("-", ""),
    ast.Not: ("not ", ""),
}
FUNCTIONS = {
    "min": "max",
    "max": "min",
    "sin": "cos",
    "cos": "sin",
    "mean": "median",
    "median": "mean",
    "argmin": "argmax",
    "argmax": "argmin",
    "any": "all",
    "all": "any",
    "minimum": "maximum",
    "maximum": "minimum",
    "floor": "ceil",
    "ceil": "floor",
    "exp": "expm1",
    "log": "log1p",
    "sum": "mean",
    "abs": "float",
    "sqrt": "abs",
}
# Calls that compute nothing.
SKIPPED_CALLS = {"InputError", "warn", "track", "dataclass", "njit", "register_jitable"}


class Mutation(NamedTuple):
    """Mutation of a file: its place, the text there, and the text that replaces it."""

    file: str
    line: int
    column: int
    length: int
    right: str
    wrong: str


class MutationFinder(ast.NodeVisitor):
    """Collect the mutations of a module."""

    def __init__(self, path: Path) -> None:
        # The syntax tree counts bytes, so each character becomes one byte.
        source = re.sub(r"[^\x00-\x7f]", "?", path.read_text(encoding="utf-8"))
        self.file = path.relative_to(PACKAGE).as_posix()
        self.lines = source.splitlines()
        self.mutations: set[Mutation] = set()
        self.visit(ast.parse(source))

    def add(self, line: int, start: int, end: int, wrong: str) -> None:
        """Add the mutation that replaces part of a line, unless it changes nothing."""
        right = self.lines[line - 1][start:end]
        if right != wrong:
            mutation = Mutation(self.file, line, start, end - start, right, wrong)
            self.mutations.add(mutation)

    def swap_operator(self, left: ast.expr, right: ast.expr, operator: ast.AST) -> None:
        """Replace the operator between two operands if all stand on one line."""
        line = left.end_lineno
        start = left.end_col_offset
        if type(operator) not in OPERATORS or line is None or right.lineno != line:
            return
        sign, wrong = OPERATORS[type(operator)]
        column = self.lines[line - 1].find(sign, start, right.col_offset)
        if column >= 0:
            self.add(line, column, column + len(sign), wrong)

    def swap_arguments(self, first: ast.expr, second: ast.expr) -> None:
        """Exchange two arguments if both stand on one line."""
        lines = {first.lineno, first.end_lineno, second.lineno, second.end_lineno}
        if len(lines) > 1 or isinstance(first, ast.Starred) or isinstance(second, ast.Starred):
            return
        line = self.lines[first.lineno - 1]
        first_text = line[first.col_offset : first.end_col_offset]
        separator = line[first.end_col_offset : second.col_offset]
        second_text = line[second.col_offset : second.end_col_offset]
        wrong = second_text + separator + first_text
        self.add(first.lineno, first.col_offset, first.col_offset + len(wrong), wrong)

    def visit_BinOp(self, node: ast.BinOp) -> None:
        self.swap_operator(node.left, node.right, node.op)
        self.generic_visit(node)

    def visit_Compare(self, node: ast.Compare) -> None:
        operands = [node.left, *node.comparators]
        for index, operator in enumerate(node.ops):
            self.swap_operator(operands[index], operands[index + 1], operator)
        self.generic_visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        for left, right in zip(node.values, node.values[1:], strict=False):
            self.swap_operator(left, right, node.op)
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        if type(node.op) in OPERATORS:
            sign, wrong = OPERATORS[type(node.op)]
            self.add(node.lineno, node.col_offset, node.col_offset + len(sign), wrong)
        self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        value = node.value
        if isinstance(value, bool) or node.end_col_offset is None:
            return
        if isinstance(value, int):
            self.add(node.lineno, node.col_offset, node.end_col_offset, repr(value + 1))
        elif isinstance(value, float):
            wrong = repr(1.1 * value or 0.1)
            self.add(node.lineno, node.col_offset, node.end_col_offset, wrong)

    def visit_Call(self, node: ast.Call) -> None:
        function: Any = node.func
        name = getattr(function, "attr", getattr(function, "id", ""))
        if name in SKIPPED_CALLS:
            return
        if name in FUNCTIONS and function.end_lineno == function.lineno:
            end = function.end_col_offset
            self.add(function.lineno, end - len(name), end, FUNCTIONS[name])
        for first, second in zip(node.args, node.args[1:], strict=False):
            self.swap_arguments(first, second)
        self.generic_visit(node)

    def visit_Raise(self, node: ast.Raise) -> None:
        """Leave the text of an error alone."""

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        """Leave text alone."""


def list_mutations(package: str) -> list[Mutation]:
    """Return every mutation of a package, in the order of its files."""
    mutations = []
    for path in sorted((PACKAGE / package).rglob("*.py")):
        mutations += sorted(MutationFinder(path).mutations)
    return mutations


def find_tests(file: str) -> list[str]:
    """Return the test files of a module, those named after it first, or else its package's folder.

    They import the module or are named after it.
    """
    package, _, module = file.removesuffix(".py").replace("/", ".").rpartition(".")
    imports = re.compile(
        rf"rockdamp\.{package}\.{module}\b|from rockdamp\.{package} import [^\n]*\b{module}\b"
    )
    prefix = f"{package}/test_{module.partition('_')[0]}"
    named_after = []
    importing = []
    for path in sorted(TESTS.rglob("test_*.py")):
        name = path.relative_to(TESTS).as_posix()
        if name.startswith(prefix):
            named_after.append(name)
        elif imports.search(path.read_text(encoding="utf-8")):
            importing.append(name)
    tests = [*named_after, *importing]
    return tests[:MOST_FILES] or [package]


def first_failure(tests: list[str], copy: Path) -> str:
    """Return the first test that fails against a copy of the package; empty if none does."""
    environment = {**os.environ, "PYTHONPATH": str(copy), "NUMBA_CACHE_DIR": str(copy / "cache")}
    command = [*PYTEST, *(str(TESTS / name) for name in tests)]
    try:
        run = subprocess.run(
            command,
            cwd=ROOT,
            env=environment,
            capture_output=True,
            text=True,
            timeout=MOST_SECONDS,
        )
    except subprocess.TimeoutExpired:
        return f"no end after {MOST_SECONDS} s"
    for line in run.stdout.splitlines():
        if line.startswith(("FAILED", "ERROR")):
            test = line.split(" ", 1)[1].split(" - ")[0]
            return test.removeprefix("tests/").partition("[")[0]
    return "exit status" if run.returncode != 0 else ""


@cache
def fails_always(test: str, copy: Path) -> bool:
    """Say whether a test fails against the package as it is."""
    return bool(first_failure([test], copy))


def try_mutation(mutation: Mutation, copy: Path) -> str:
    """Return the test that notices a mutation of a copy of the package."""
    path = copy / "rockdamp" / mutation.file
    original = path.read_text(encoding="utf-8")
    lines = original.splitlines(keepends=True)
    line = lines[mutation.line - 1]
    end = mutation.column + mutation.length
    lines[mutation.line - 1] = line[: mutation.column] + mutation.wrong + line[end:]
    path.write_text("".join(lines), encoding="utf-8")
    failure = first_failure(find_tests(mutation.file), copy)
    path.write_text(original, encoding="utf-8")
    if "::" in failure and fails_always(failure, copy):
        return f"**{failure} fails without it too**"
    return failure or SURVIVED


def parse_arguments() -> argparse.Namespace:
    """Return the arguments of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="table of mutations and outcomes")
    parser.add_argument("--count", type=int, default=150, help="mutations in the sample")
    parser.add_argument("--seed", type=int, default=51, help="seed of the sample")
    parser.add_argument(
        "--package", nargs="+", choices=PACKAGES, default=PACKAGES, help="packages to run"
    )
    return parser.parse_args()


def main() -> None:
    """Draw the sample if there is none, and try the mutations that have no outcome."""
    arguments = parse_arguments()
    generator = random.Random(arguments.seed)
    mutations = {package: list_mutations(package) for package in PACKAGES}
    if not arguments.file.exists():
        population = [mutation for members in mutations.values() for mutation in members]
        sample = pd.DataFrame(generator.sample(population, arguments.count))
        sample = sample.assign(noticed="", seconds="", equivalent="")
        sample.to_csv(arguments.file, index=False)
    texts = ("right", "wrong", "noticed", "seconds", "equivalent")
    table = pd.read_csv(arguments.file, dtype=dict.fromkeys(texts, str), keep_default_na=False)
    columns = list(Mutation._fields)
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder)
        shutil.copytree(PACKAGE, copy / "rockdamp", ignore=shutil.ignore_patterns("__pycache__"))
        for index, row in table[table["noticed"] == ""].iterrows():
            package = row["file"].partition("/")[0]
            if package not in arguments.package:
                continue
            mutation = Mutation(*row[columns])
            if mutation not in mutations[package]:
                mutation = generator.choice(mutations[package])
                table.loc[index, columns] = mutation
            start = time.perf_counter()
            noticed = try_mutation(mutation, copy)
            seconds = f"{time.perf_counter() - start:.0f}"
            table.loc[index, ["noticed", "seconds"]] = [noticed, seconds]
            table.to_csv(arguments.file, index=False)
            print(mutation.file, mutation.line, mutation.right, mutation.wrong, noticed, flush=True)
    judged = table[(table["noticed"] != "") & (table["equivalent"] == "")]
    is_noticed = judged["noticed"] != SURVIVED
    print(is_noticed.groupby(judged["file"].str.partition("/")[0]).agg(["count", "sum", "mean"]))


if __name__ == "__main__":
    main()
