"""The pages of the documents: their blocks of code run in a copy of the tree, as a reader's do.

- ``sh``: commands.
- ``console``: commands after ``$``, and their output; a line ``...`` stands for lines left out.
- ``python``: a program, or a session with ``>>>``, of which the values are compared.
- A block whose first line names a file, ``# my-wall.yaml``, is that file. In
  ``# config/default.yaml, after: studies:`` the line says where an edit goes.

Snakemake runs on the minimal config, beneath a page's own.
"""

import contextlib
import doctest
import re
import shlex
import subprocess
import sys
from itertools import groupby

from click.testing import CliRunner
from repository import ROOT
from rounded_texts import alike, holds
from workflow_tree import Tree

from rockdamp.cli import main

BLOCK = re.compile(r"^```(sh|console|python|yaml)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
PLACE = re.compile(r"# (?P<file>[\w./-]+\.\w+)(?:, (?P<where>before|after): (?P<line>.+))?")
FULL = (ROOT / "results/report.html").exists()
PAGES = [
    "README.md",
    "CONTRIBUTING.md",
    *(str(path.relative_to(ROOT)) for path in sorted(ROOT.glob("docs/**/*.md"))),
]


class Checker(doctest.OutputChecker):
    """Numbers count as values."""

    def check_output(self, want, got, optionflags):
        return alike(want, got) or super().check_output(want, got, optionflags)


class Anything(doctest.OutputChecker):
    """Only that the code runs counts."""

    def check_output(self, want, got, optionflags):
        return True


def read(page):
    return (ROOT / page).read_text(encoding="utf-8")


def make_tree(place):
    """A copy of the tree in which `.venv/bin` has the commands of this environment."""
    tree = Tree(place)
    folder = tree.place / ".venv/bin"
    folder.mkdir(parents=True)
    commands = {"python": "", "snakemake": "-m snakemake", "rockdamp": "-m rockdamp"}
    for name, options in commands.items():
        script = f'#!/bin/sh\nexec "{sys.executable}" {options} "$@"\n'
        (folder / name).write_text(script, encoding="utf-8")
        (folder / name).chmod(0o755)
    path = f"{folder}:{tree.environment['PATH']}"  # as `source .venv/bin/activate` leaves it
    tree.environment |= {"PATH": path, "MPLBACKEND": "agg"}
    return tree


def link_results(tree, results):
    """Show a copy of the tree the results of a build; what the copy builds goes elsewhere."""
    (tree.place / "results").mkdir()
    for result in results.iterdir():
        if result.name != "minimal":
            (tree.place / "results" / result.name).symlink_to(result)


def reads_results(page):
    """Whether the Python of a page opens results of a full build."""
    return re.search(r"\(\"results/(?!my-|minimal)", read(page)) is not None


def edit(tree, place, code):
    """Write a block as a file, or into a file at the line that the block names."""
    path = tree.place / place["file"]
    if place["where"]:
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
        number = find_line(lines, place["line"])
        if place["where"] == "after":
            number += 1
        code = "".join([*lines[:number], code, *lines[number:]])
    path.write_text(code, encoding="utf-8")


def find_line(lines, line):
    """Return the number of a line; one that is not indented goes before those that are."""
    numbers = [number for number, text in enumerate(lines) if text.rstrip() == line]
    if not numbers:
        numbers = [number for number, text in enumerate(lines) if text.strip() == line]
    (number,) = numbers
    return number


def run_shell(tree, command, edited):
    """Return the output of a command.

    A command of rockdamp runs in this process unless the copy was edited.
    """
    if command.startswith("rockdamp ") and not edited and not re.search("[|>;]", command):
        with contextlib.chdir(tree.place):
            result = CliRunner().invoke(main, shlex.split(command)[1:])
        assert result.exit_code == 0, command + result.output
        return result.output
    command = command.replace("--configfile ", "--configfile config/minimal.yaml ")
    if command.startswith("snakemake ") and "--configfile" not in command:
        command += " --configfile config/minimal.yaml"
    result = run_process(tree, ["sh", "-ec", command])
    assert result.returncode == 0, command + result.stdout + result.stderr
    return result.stdout


def run_process(tree, command):
    options = {"capture_output": True, "text": True}
    return subprocess.run(command, cwd=tree.place, env=tree.environment, **options)


def run_console(tree, block, edited):
    """Run the commands of a block and compare what they print."""
    for text in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
        command, _, expected = text.partition("\n")
        output = run_shell(tree, command.removeprefix(".venv/bin/"), edited)
        for is_gap, lines in groupby(expected.splitlines(), "...".__eq__):
            part = "\n".join(lines).strip("\n")
            assert is_gap or not part or holds(output, part), f"{command}\n{output}"


def run_program(tree, block):
    """Run a program in an interpreter of its own."""
    result = run_process(tree, [sys.executable, "-W", "error", "-c", block])
    assert result.returncode == 0, block + result.stderr


def run_session(tree, block, names, checker):
    """Run a session with the names of those before it."""
    session = doctest.DocTestParser().get_doctest(block, names, "session", None, 0)
    with contextlib.chdir(tree.place):
        runner = doctest.DocTestRunner(checker, optionflags=doctest.NORMALIZE_WHITESPACE)
        assert runner.run(session, clear_globs=False).failed == 0
    names |= session.globs


def run_page(tree, page):
    """Run all blocks of a page in order; numbers of full results are compared where they exist."""
    names = {}
    edited = False
    checker = Checker() if FULL or not reads_results(page) else Anything()
    for language, block in BLOCK.findall(read(page)):
        first, _, code = block.partition("\n")
        if place := PLACE.fullmatch(first):
            edit(tree, place, code)
            if not place["file"].startswith("my-"):
                edited = True
                tree.use_package(tree.place)
        elif language == "python" and ">>> " in block:
            run_session(tree, block, names, checker)
        elif language == "python":
            run_program(tree, block)
        elif language == "console":
            run_console(tree, block.replace("\\\n", " "), edited)
        elif language == "sh":
            for command in block.replace("\\\n", " ").splitlines():
                run_shell(tree, command.replace(".venv/bin/", ""), edited)
