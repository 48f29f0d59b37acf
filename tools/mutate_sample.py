"""Break the science at random places, and count what the tests notice.

    .venv/bin/python tools/mutate_sample.py FILE.csv [--count 150] [--seed 51] [--package NAME ...]

Mutations are made from the syntax tree: operators, comparisons, numbers, signs, arguments and names
of functions. Each place of the packages is as likely as any other. A mutation is noticed if a test
fails in one of the files that import the module or are named after it. FILE gets the whole sample
at first, and then what came out, row by row: a second run goes on where the first one stopped, and
--package takes the rows of these packages alone. A place that was edited since is drawn again in
its package. Whether a survivor changes a value is judged by hand, in the column `equivalent`.
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
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pandas as pd

ROOT = Path(__file__).resolve().parents[1]
PACKAGE, TESTS = ROOT / "src/rockdamp", ROOT / "tests"
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
PYTEST = [
    sys.executable,
    *"-m pytest -x -q --no-header -p no:cacheprovider --tb=no -m".split(),
    "not peers",
]
MOST_FILES = 6  # of tests of a module
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
PAIRS = (
    "min max",
    "sin cos",
    "mean median",
    "argmin argmax",
    "any all",
    "minimum maximum",
    "floor ceil",
)
NAMES = {"exp": "expm1", "log": "log1p", "sum": "mean", "abs": "float", "sqrt": "abs"}
NAMES |= {one: other for pair in PAIRS for one, other in (pair.split(), pair.split()[::-1])}
TEXTS = {
    "InputError",
    "warn",
    "track",
    "dataclass",
    "njit",
    "register_jitable",
}  # calls that compute nothing


class Places(ast.NodeVisitor):
    """Collect the places of a module that a mutation may change: line, column, length and the new
    text.
    """

    def __init__(self, source: str) -> None:
        self.lines = source.splitlines()
        self.found: set[tuple[int, int, int, str]] = set()
        self.visit(ast.parse(source))

    def swap_sign(self, left: ast.expr, right: ast.expr, operator: ast.AST) -> None:
        """Change the sign between two operands, if it stands between them on one line."""
        line, start = left.end_lineno, left.end_col_offset
        if type(operator) not in OPERATORS or line is None or right.lineno != line:
            return
        sign, other = OPERATORS[type(operator)]
        column = self.lines[line - 1].find(sign, start, right.col_offset)
        if column >= 0:
            self.found.add((line, column, len(sign), other))

    def visit_BinOp(self, node: ast.BinOp) -> None:
        self.swap_sign(node.left, node.right, node.op)
        self.generic_visit(node)

    def visit_Compare(self, node: ast.Compare) -> None:
        for left, operator, right in zip(
            [node.left, *node.comparators], node.ops, node.comparators, strict=False
        ):
            self.swap_sign(left, right, operator)
        self.generic_visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        for left, right in zip(node.values, node.values[1:], strict=False):
            self.swap_sign(left, right, node.op)
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        if type(node.op) in OPERATORS:
            sign, other = OPERATORS[type(node.op)]
            self.found.add((node.lineno, node.col_offset, len(sign), other))
        self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        value, end = node.value, node.end_col_offset
        if not isinstance(value, bool) and isinstance(value, int | float) and end is not None:
            other = value + 1 if isinstance(value, int) else 1.1 * value or 0.1
            self.found.add((node.lineno, node.col_offset, end - node.col_offset, repr(other)))

    def visit_Call(self, node: ast.Call) -> None:
        function: Any = node.func
        name = getattr(function, "attr", getattr(function, "id", ""))
        if name in TEXTS:
            return
        if name in NAMES and function.end_lineno == function.lineno:
            self.found.add(
                (function.lineno, function.end_col_offset - len(name), len(name), NAMES[name])
            )
        for first, second in zip(node.args, node.args[1:], strict=False):
            same = first.lineno == first.end_lineno == second.lineno == second.end_lineno
            if same and not isinstance(first, ast.Starred) and not isinstance(second, ast.Starred):
                line = self.lines[first.lineno - 1]
                one, two = (line[arg.col_offset : arg.end_col_offset] for arg in (first, second))
                between = line[first.end_col_offset : second.col_offset]
                self.found.add(
                    (first.lineno, first.col_offset, len(one + between + two), two + between + one)
                )
        self.generic_visit(node)

    def visit_Raise(self, node: ast.Raise) -> None:
        """Leave the text of an error alone."""

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        """Leave text alone."""


def mutations(package: str) -> Iterator[dict[str, Any]]:
    """Yield every mutation of a package, in the order of its files."""
    for path in sorted((PACKAGE / package).rglob("*.py")):
        source = re.sub(
            r"[^\x00-\x7f]", "?", path.read_text(encoding="utf-8")
        )  # the tree counts bytes
        for line, column, length, wrong in sorted(Places(source).found):
            right = source.splitlines()[line - 1][column : column + length]
            if right != wrong:
                place = {
                    "line": line,
                    "column": column,
                    "length": length,
                    "right": right,
                    "wrong": wrong,
                }
                yield {"file": path.relative_to(PACKAGE).as_posix(), **place}


def near_tests(file: str) -> list[str]:
    """Return the files of tests that import a module or are named after it, its own first; else its
    package's.
    """
    package, _, module = file.removesuffix(".py").replace("/", ".").rpartition(".")
    imports = re.compile(
        rf"rockdamp\.{package}\.{module}\b|from rockdamp\.{package} import [^\n]*\b{module}\b"
    )
    named, found = f"{package}/test_{module.partition('_')[0]}", []
    for path in sorted(TESTS.rglob("test_*.py")):
        inside = path.relative_to(TESTS).as_posix()
        if inside.startswith(named) or imports.search(path.read_text(encoding="utf-8")):
            found.append(inside)
    found.sort(key=lambda inside: not inside.startswith(named))
    return found[:MOST_FILES] or [package]


def first_failure(tests: list[str], copy: Path) -> str:
    """Return the first of the tests that fails against a copy of the package; empty if none does."""
    environment = {**os.environ, "PYTHONPATH": str(copy), "NUMBA_CACHE_DIR": str(copy / "cache")}
    command = [*PYTEST, *(str(TESTS / name) for name in tests)]
    try:
        run = subprocess.run(
            command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=600
        )
    except subprocess.TimeoutExpired:
        return "no end after 600 s"
    failed = [
        line.split(" ", 1)[1]
        for line in run.stdout.splitlines()
        if line.startswith(("FAILED", "ERROR"))
    ]
    name = failed[0].split(" - ")[0] if failed else "exit status" * (run.returncode != 0)
    return name.removeprefix("tests/").partition("[")[0]


@cache
def fails_always(test: str, copy: Path) -> bool:
    return bool(first_failure([test], copy))


def outcome(row: pd.Series, copy: Path) -> str:
    """Return which test notices a mutation."""
    path = copy / "rockdamp" / row["file"]
    right = path.read_text(encoding="utf-8")
    lines = right.splitlines(keepends=True)
    number, start = row["line"] - 1, row["column"]
    lines[number] = lines[number][:start] + row["wrong"] + lines[number][start + row["length"] :]
    path.write_text("".join(lines), encoding="utf-8")
    failed = first_failure(near_tests(row["file"]), copy)
    path.write_text(right, encoding="utf-8")
    if "::" in failed and fails_always(failed, copy):
        return f"**{failed} fails without it too**"
    return failed or SURVIVED


def main() -> None:
    options = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    options.add_argument(
        "file", type=Path, metavar="FILE", help="table of the sample and of what came out"
    )
    options.add_argument("--count", type=int, default=150, help="mutations in the sample")
    options.add_argument("--seed", type=int, default=51, help="of the sample")
    options.add_argument(
        "--package",
        nargs="+",
        choices=PACKAGES,
        default=PACKAGES,
        help="run those of some packages",
    )
    asked = options.parse_args()
    drawer = random.Random(asked.seed)
    places = {package: list(mutations(package)) for package in PACKAGES}
    if not asked.file.exists():
        sample = drawer.sample([place for one in places.values() for place in one], asked.count)
        pd.DataFrame(sample).assign(noticed="", seconds="", equivalent="").to_csv(
            asked.file, index=False
        )
    text = dict.fromkeys(("right", "wrong", "noticed", "seconds", "equivalent"), str)
    table = pd.read_csv(asked.file, dtype=text, keep_default_na=False)
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder)
        shutil.copytree(PACKAGE, copy / "rockdamp", ignore=shutil.ignore_patterns("__pycache__"))
        for index, row in table[table["noticed"] == ""].iterrows():
            package = row["file"].partition("/")[0]
            if package not in asked.package:
                continue
            if row[list(places[package][0])].to_dict() not in places[package]:
                table.loc[index, list(places[package][0])] = drawer.choice(places[package])
            start = time.perf_counter()
            table.loc[index, "noticed"] = outcome(table.loc[index], copy)
            table.loc[index, "seconds"] = f"{time.perf_counter() - start:.0f}"
            table.to_csv(asked.file, index=False)
            print(*table.loc[index, ["file", "line", "right", "wrong", "noticed"]], flush=True)
    done = table[(table["noticed"] != "") & (table["equivalent"] == "")]
    noticed = (done["noticed"] != SURVIVED).groupby(done["file"].str.partition("/")[0])
    print(noticed.agg(["count", "sum", "mean"]))


if __name__ == "__main__":
    main()
