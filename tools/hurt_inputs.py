"""Attacks at random on records and commands, faults in the writer, and what calls hold.

Parts of `hurt.py`. The tests run some of the attacks on records and commands, with another seed.
"""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Callable, Iterable
from itertools import islice
from pathlib import Path

import hurt_faults as faults
from attacks import ANSWER, REFUSED, Attack, ended
from command_attacks import command_attacks
from record_attacks import record_attacks

Report = Callable[[str, str, str, str, bool], None]
WARM = 50  # calls before what is held is measured
CALLS = 2000
GROWTH = 20.0  # MB that memory may grow by over so many calls: what allocators keep
EXPECTED = "an answer or a refusal in one line"
# Of the commands; a record of a test takes seconds.
SHARES = {
    "lists": 0.35,
    "outputs": 0.25,
    "raw tables": 0.2,
    "priors": 0.14,
    "records of tests": 0.06,
}


def inputs(report: Report, seed: int, count: int) -> None:
    """Attack the reader of records `count` times."""
    _told(report, "inputs", "records", seed, _ends(islice(record_attacks(seed), count)))


def commands(report: Report, seed: int, count: int) -> None:
    """Run `count` commands that were mistyped, or that have files that were."""
    for kind, share in SHARES.items():
        _told(report, "commands", kind, seed, _ends(islice(command_attacks(seed, kind), round(share * count))))


def _ends(attacks: Iterable[Attack]) -> Counter[str]:
    found: Counter[str] = Counter()
    for attack in attacks:
        with tempfile.TemporaryDirectory() as folder:
            how = ended(attack, Path(folder))
        found[how if how in (ANSWER, REFUSED) else f"{attack.kind}: {how}"] += 1
    return found


def _told(report: Report, part: str, kind: str, seed: int, ended: Counter[str]) -> None:
    good = ended["answer"] + ended["refused"]
    seen = f"{good} of {ended.total()}: {ended['answer']} right answers, {ended['refused']} refused"
    others = [f"{count} x {what}" for what, count in ended.items() if what not in ("answer", "refused")]
    report(part, f"{ended.total()} {kind}, seed {seed}", EXPECTED, "; ".join([seen, *others]), not others)


def writer(report: Report) -> None:
    """Let each call of each writer fail once, by each fault."""
    ended: Counter[str] = Counter()
    for name, run in faults.writer_attacks():
        with tempfile.TemporaryDirectory() as folder:
            found = run(Path(folder))
        ended[found if found in ("answer", "refused") else f"{name}: {found}"] += 1
    others = [what for what in ended if what not in ("answer", "refused")]
    seen = f"{ended['refused']} failures told, {ended['answer']} writes unharmed"
    done = f"{ended.total()} writes, each with a full or failing disk, no memory or an interrupt at one of its calls"
    report("writer", done, "the old result or the new one, whole", "; ".join([seen, *others]), not others)


def resources(report: Report) -> None:
    """Call the package many times over and see what the process holds."""
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(WARM):
            faults.call_once(Path(folder))
        before = faults.held()
        for _ in range(CALLS):
            faults.call_once(Path(folder))
        after = faults.held()
    grown = {name: after[name] - before[name] for name in before}
    good = grown["memory"] < GROWTH and grown["threads"] == grown["files"] == 0
    seen = f"{grown['memory']:+.1f} MB, {grown['threads']:+.0f} threads, {grown['files']:+.0f} open files"
    report("resources", f"{CALLS} calls of each function", f"under {GROWTH:g} MB, none more", seen, good)
