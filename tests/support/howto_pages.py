"""A how-to's edits, made as the page says, and its commands.

The first line of a block of code names the file, ``# config/default.yaml, after: studies:``; a file that is not
there is made of the block.
"""

import contextlib
import re
import shlex
import subprocess
import sys

from click.testing import CliRunner
from repository import ROOT
from workflow_tree import Tree

from rockdamp.cli import main

PLACE = re.compile(r"# (?P<file>[\w./-]+\.\w+)(?:, (?P<where>before|after): (?P<line>.+))?")


REPORT = """
from report_content import content
from rockdamp import report
print(report.build(content()))
"""


def blocks(page, *languages):
    """The blocks of code of a page, in their order."""
    text = (ROOT / f"docs/howto/{page}.md").read_text(encoding="utf-8")
    wanted = "|".join(languages)
    return re.findall(rf"^```(?:{wanted})\n(.*?)^```$", text, flags=re.MULTILINE | re.DOTALL)


def make_tree(place):
    """A copy of the tree in which `.venv/bin` has the commands of this environment."""
    tree = Tree(place)
    bin = tree.place / ".venv/bin"
    bin.mkdir(parents=True)
    for name, options in {"python": "", "snakemake": "-m snakemake", "rockdamp": "-m rockdamp"}.items():
        (bin / name).write_text(f'#!/bin/sh\nexec "{sys.executable}" {options} "$@"\n', encoding="utf-8")
        (bin / name).chmod(0o755)
    return tree


def edit(tree, page):
    """Make the edits of a page in a copy of the tree."""
    for block in blocks(page, "python", "yaml", "markdown"):
        first, _, code = block.partition("\n")
        place = PLACE.fullmatch(first)
        assert place, f"{page}.md: {first!r} does not say where the block goes"
        path = tree.place / place["file"]
        if place["where"] is None:
            assert not path.exists(), path
            path.write_text(code, encoding="utf-8")
            continue
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
        same = [line for line in lines if line.rstrip() == place["line"]] or lines
        (at,) = [number for number, line in enumerate(lines) if line in same and line.strip() == place["line"]]
        lines.insert(at + (place["where"] == "after"), code)
        path.write_text("".join(lines), encoding="utf-8")


def follow(tree, page, edited=False):
    """Run the commands of a page with coarser steps than the config's; return what they print.

    A block that holds nothing but commands of `rockdamp` runs in this process, unless the copy's package was edited.
    """
    printed = ""
    path = f"{tree.place}/.venv/bin:{tree.environment['PATH']}"  # as `source .venv/bin/activate` leaves it
    environment = {**tree.environment, "PATH": path}
    for block in blocks(page, "sh"):
        lines = [line.removeprefix(".venv/bin/") for line in block.replace("\\\n", " ").splitlines()]
        if not edited and all(line.startswith("rockdamp ") for line in lines):
            with contextlib.chdir(tree.place):
                for line in lines:
                    result = CliRunner().invoke(main, shlex.split(line)[1:])
                    assert result.exit_code == 0, line + result.output
                    printed += result.stdout
            continue
        command = block.replace("--configfile ", "--configfile config/minimal.yaml ")
        run = subprocess.run(["sh", "-ec", command], cwd=tree.place, env=environment, capture_output=True, text=True)
        assert run.returncode == 0, block + run.stdout + run.stderr
        printed += run.stdout
    return printed


def python(tree, *arguments):
    """Run Python in the copy, with the helpers of its tests on the path; return what it prints."""
    places = [str(tree.place / name) for name in ("src", "tests/support")]
    environment = {**tree.environment, "PYTHONPATH": ":".join(places)}
    done = subprocess.run([sys.executable, *arguments], cwd=tree.place, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
