"""Hurt the package and its pipeline and see that they survive: `.venv/bin/python tools/hurt.py [--seed 5] [PART ...]`.

Run by hand. Parts: killed, orphans, two-runs, damaged, folders, surroundings, install. Where none is named, all but the
last, which downloads packages. `--kills 20` says how many kills. `--page` writes the table into docs/robustness.md,
where a part that was run replaces its rows. The minimal config is built in a copy of the tree whose path has a space
and a letter beyond ASCII; whatever is done then must end in the same bytes or in a clear error. The table says what was
done, what had to happen and what did; the exit status is 1 if these differ anywhere.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import xarray as xr
from pipeline_tree import RESULTS, Tree, last_lines, line_with

CHEAP = ("fig1", "convergence", "coefficients")  # targets: a figure, a dataset and a table in seconds
CHEAP_FILES = ("mechanism.nc", "convergence.nc", "coefficients.csv", "figures/fig1.pdf", "figures/fig1.png")
PER_BUILD = 10  # kills, one after the other, before a build is left to end
STARTED = time.monotonic()


class Row(NamedTuple):
    """A line of the table."""

    part: str
    done: str
    expected: str
    seen: str
    good: bool


ROWS: list[Row] = []


def note(text: str) -> None:
    print(f"[{time.monotonic() - STARTED:5.0f} s] {text}", flush=True)


def report(part: str, done: str, expected: str, seen: str, good: bool) -> None:
    ROWS.append(Row(part, done, expected, seen, good))
    note(f"{'ok  ' if good else 'FAIL'} {part}: {done}: {seen}")


# --- kills -----------------------------------------------------------------------------------------------------------


def kill(process: subprocess.Popen[bytes], whole_group: bool) -> None:
    if whole_group:
        os.killpg(process.pid, signal.SIGKILL)
    else:
        process.kill()
    process.wait()


def end_group(process: subprocess.Popen[bytes]) -> int:
    """Kill what is left of a process group; return 1 if there was anything, else 0."""
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        return 0
    return 1


def kills(tree: Tree, rng: random.Random, count: int, whole_group: bool) -> None:
    """Kill builds at random moments, let each end, and compare."""
    part, done = ("killed", 0) if whole_group else ("orphans", 0)
    while done < count:
        tree.clear()
        hurt, bad, left = 0, [], []
        while hurt < min(PER_BUILD, count - done):
            moment = rng.uniform(0, 2 * tree.seconds / (PER_BUILD + 1))
            process = tree.start()
            try:
                process.wait(timeout=moment)
                break  # it ended first
            except subprocess.TimeoutExpired:
                kill(process, whole_group)
            hurt += 1
            left.append(process)
            bad += tree.truncated()
            note(f"{part}: kill {done + hurt} of {count} after {moment:.1f} s, {len(tree.digests())} results stand")
            unlock(tree)
        done += hurt
        healed(tree, part, hurt, bad)
        alive = sum(map(end_group, left))
        if alive:
            note(f"{part}: {alive} orphaned groups still ran at the end")


def unlock(tree: Tree) -> None:
    if tree.locked():
        tree.call([*tree.command, "--unlock"])


def healed(tree: Tree, part: str, hurt: int, bad: list[str]) -> None:
    """Let the build end, as the README says, and compare it."""
    runs, run = 1, tree.call([*tree.command, "--rerun-incomplete"])
    while run.returncode and runs < 3:
        note(f"{part}: run {runs} after the kills ended with status {run.returncode}: {last_lines(run)}")
        runs, run = runs + 1, tree.call([*tree.command, "--rerun-incomplete"])
    other = tree.differences()
    seen = f"{len(tree.whole) - len(other)} of {len(tree.whole)} files the same after {runs} run(s)"
    seen += f"; truncated at a kill: {sorted(set(bad))}" if bad else ""
    seen += f"; different: {other}" if other else ""
    report(part, f"{hurt} kills in one build", "the same bytes, no truncated result", seen, not (bad or other))


def two_runs(tree: Tree) -> None:
    tree.clear()
    first = tree.start()
    for _ in range(600):
        if tree.locked() or first.poll() is not None:
            break
        time.sleep(0.1)
    second = tree.run()
    kill(first, whole_group=True)
    unlock(tree)
    said = line_with(second, "cannot be locked")
    report(
        "two runs", "a second run during the first", "says that it is locked", said, bool(second.returncode and said)
    )


# --- damaged results -------------------------------------------------------------------------------------------------


def flip(path: Path) -> None:
    """Flip a bit of a value. In the structure of a file a flipped bit can be worse: HDF5 may then never return."""
    with xr.open_dataset(path) as opened:
        values = max((variable.values for variable in opened.data_vars.values()), key=lambda array: array.nbytes)
    content = bytearray(path.read_bytes())
    content[content.index(values.tobytes()) + values.nbytes // 2] ^= 4
    path.write_bytes(content)


DAMAGES: dict[str, Callable[[Path], object]] = {
    "truncated": lambda path: os.truncate(path, path.stat().st_size // 2),
    "flipped": flip,
    "empty": lambda path: os.truncate(path, 0),
    "text": lambda path: path.write_bytes(b"not a dataset\n"),
}
VICTIMS = [
    *(("mechanism.nc", "fig1", damage) for damage in DAMAGES),
    ("match/cracked_stiffness.nc", "equivalence_fit", "flipped"),
    ("equivalence.nc", "coefficients", "truncated"),
    ("response_lengths.nc", "claims", "text"),
    ("damping_force.nc", "report", "empty"),
]


def damaged(tree: Tree) -> None:
    """Damage a dataset: what reads it must refuse it, and once it is deleted all must come out as before."""
    tree.run()
    for name, target, damage in VICTIMS:
        path = tree.results / name
        DAMAGES[damage](path)
        refused = line_with(tree.run(target), path.name, "delete it and run again")
        path.unlink()
        run = tree.run(f"{RESULTS}/{name}", target)
        parts = list(tree.results.rglob("*.part"))
        other = [file for file in tree.differences() if file == name] + parts
        good = bool(refused) and not (other or run.returncode)
        seen = "a line, and the same" if good else f"{refused or 'no line'}; different: {other}; {last_lines(run)}"
        report(
            "damaged", f"{name} {damage}, then {target}", "a line that names it; built again once deleted", seen, good
        )
    run = tree.run()
    other = tree.differences()
    seen = f"different: {other}; {last_lines(run)}" if other else "the same"
    report("damaged", "all of it run again", "the same bytes", seen, not other)


# --- folders that cannot be written ----------------------------------------------------------------------------------


def mounted(tree: Tree, where: str, options: str, targets: tuple[str, ...]) -> subprocess.CompletedProcess[str]:
    """Run snakemake with a small or read-only disk mounted in the tree, which no other process sees.

    A disk in use is not empty: Snakemake takes away the folders that are, and stumbles over one that is a disk.
    """
    script = (
        'mount -t tmpfs tmpfs "$2" && touch "$2/kept" && mount -o "remount,$1" "$2" && shift 2 && "$@"; status=$?; '
    )
    script += f'find "{RESULTS}" -name "*.part" | sed "s/^/left over: /"; exit $status'
    unshared = ["unshare", "--map-root-user", "--mount", "sh", "-c", script, "sh", options, where]
    return tree.call([*unshared, *tree.command, "--", *targets])


def folders(tree: Tree) -> None:
    able = shutil.which("unshare") and tree.call(["unshare", "--map-root-user", "--mount", "true"]).returncode == 0
    if not able:
        report("folders", "read-only and full disk", "a clear error", "skipped: mounting is not permitted here", True)
    for where, options, word in (
        (
            (RESULTS, "ro", "cannot be written"),
            (RESULTS, "size=60k", "cannot be written"),
            (f"{RESULTS}/figures", "size=8k", "No space left"),
            (f"{RESULTS}/figures", "ro", "cannot be written"),
        )
        if able
        else ()
    ):
        (tree.place / where).mkdir(parents=True, exist_ok=True)
        target = "fig1" if where.endswith("figures") else "mechanism"
        run = mounted(tree, where, options, (target,))
        said = line_with(run, word)
        good = bool(run.returncode and said and "left over" not in run.stdout)
        report(
            "folders", f"{where} on a disk with {options}", "one line, no .part", said[:110] or last_lines(run), good
        )
    record = tree.place / "data/sin-03-00-synthetic.csv"
    content = record.read_bytes()
    record.unlink()
    run = tree.run()
    record.write_bytes(content)
    said = line_with(run, "validation.record", "must be a file")
    report("folders", "no record", "one line", said[:110] or last_lines(run), bool(run.returncode and said))


# --- surroundings ----------------------------------------------------------------------------------------------------


SURROUNDINGS: dict[str, dict[str, str | None]] = {
    "LC_ALL=C": {"LC_ALL": "C"},
    "tr_TR.UTF-8": {"LC_ALL": "tr_TR.UTF-8"},
    "no HOME": {"HOME": None},
    "HOME read-only": {"HOME": "/proc"},  # with a cache in the tree, as make asks for
    "PYTHONHASHSEED=1": {"PYTHONHASHSEED": "1"},
    "PYTHONHASHSEED=4294967295": {"PYTHONHASHSEED": "4294967295"},
    "PYTHONDONTWRITEBYTECODE": {"PYTHONDONTWRITEBYTECODE": "1"},
    "TZ in the Pacific": {"TZ": "Pacific/Kiritimati"},
}


def surroundings(tree: Tree) -> None:
    installed = subprocess.run(["locale", "-a"], capture_output=True, text=True, check=False).stdout.lower()
    tree.run()
    for name, changes in SURROUNDINGS.items():
        if name.startswith("HOME"):
            changes = {**changes, "XDG_CACHE_HOME": str(tree.place / ".cache")}
        if name.startswith("tr_TR") and "tr_tr" not in installed:
            report("surroundings", name, "the same bytes", "skipped: the locale is not installed", True)
            continue
        cheap(tree, name, **changes)
    with umask(0o077):
        cheap(tree, "umask 077")


@contextmanager
def umask(mask: int) -> Iterator[None]:
    before = os.umask(mask)
    try:
        yield
    finally:
        os.umask(before)


def cheap(tree: Tree, name: str, **changes: str | None) -> None:
    """Build a few results again and compare them."""
    for file in CHEAP_FILES:
        (tree.results / file).unlink(missing_ok=True)
    run = tree.run(*CHEAP, **changes)
    now = tree.digests()
    other = [file for file in CHEAP_FILES if now.get(file) != tree.whole[file]]
    seen = f"different: {other}; {last_lines(run)}" if other else "the same"
    report("surroundings", name, "the same bytes", seen, not other)


# --- make ------------------------------------------------------------------------------------------------------------


def install(tree: Tree, rng: random.Random) -> None:
    """Kill `make setup` three times on its way, then let it end."""
    environment = {key: value for key, value in tree.environment.items() if key != "PYTHONPATH"}
    options = {"cwd": tree.place, "env": environment}
    moments = []
    for latest in (8, 25, 50):
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "start_new_session": True}
        process = subprocess.Popen(["make", "setup"], **options, **quiet)
        moments.append(rng.uniform(latest / 3, latest))
        try:
            process.wait(timeout=moments[-1])
        except subprocess.TimeoutExpired:
            kill(process, whole_group=True)
        note(f"install: killed after {moments[-1]:.0f} s")
    done = subprocess.run(["make", "setup"], **options, capture_output=True, text=True)
    answer = subprocess.run([".venv/bin/rockdamp", "--version"], **options, capture_output=True, text=True)
    seen = answer.stdout.strip() or done.stderr[-200:]
    when = ", ".join(f"{moment:.0f}" for moment in moments)
    report("install", f"make setup killed after {when} s, then run", "ends well", seen, answer.returncode == 0)


# --- all -------------------------------------------------------------------------------------------------------------


def build(tree: Tree) -> None:
    """Build undisturbed, with an empty cache of numba, which is kept."""
    note("an undisturbed build")
    start = time.monotonic()
    run = tree.run()
    tree.seconds = time.monotonic() - start
    if run.returncode:
        sys.exit(run.stdout + run.stderr)
    tree.whole = tree.digests()
    note(f"{len(tree.whole)} files in {tree.seconds:.0f} s")


HEAD = ("| part | what was done | what had to happen | what did | |", "|---|---|---|---|---|")
PAGE = Path(__file__).resolve().parents[1] / "docs/robustness.md"
BLOCK = re.compile(r"(?<=<!-- tools/hurt.py -->\n).*?(?=<!-- end -->)", re.DOTALL)


def table() -> list[str]:
    """The lines of the table so far."""
    return [
        f"| {row.part} | {row.done} | {row.expected} | {row.seen} | {'ok' if row.good else '**no**'} |" for row in ROWS
    ]


def write_page(lines: list[str]) -> None:
    """Put rows into the table of the page, in place of those of the same parts."""
    text = PAGE.read_text(encoding="utf-8")
    shown = [line for line in BLOCK.findall(text)[0].splitlines() if line.startswith("| ")][1:]
    done = {line.split(" | ")[0] for line in lines}
    kept = [line for line in shown if line.split(" | ")[0] not in done]
    block = "\n".join([*HEAD, *kept, *lines, ""])
    PAGE.write_text(BLOCK.sub(lambda _: block, text), encoding="utf-8")


def main() -> int:
    """Run the parts that are named, or all but the installation."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART")
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--page", action="store_true")
    given = parser.parse_args()
    rng = random.Random(given.seed)
    parts: dict[str, Callable[[Tree], None]] = {
        "killed": lambda tree: kills(tree, rng, given.kills, whole_group=True),
        "orphans": lambda tree: kills(tree, rng, given.kills, whole_group=False),
        "two-runs": two_runs,
        "damaged": damaged,
        "folders": folders,
        "surroundings": surroundings,
        "install": lambda tree: install(tree, rng),
    }
    if unknown := [name for name in given.parts if name not in parts]:
        parser.error(f"no part {', '.join(unknown)}; there are {', '.join(parts)}")
    chosen = given.parts or [name for name in parts if name != "install"]
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        tree = Tree(Path(folder, "a träe"))
        if chosen != ["install"]:
            build(tree)
        for name in chosen:
            parts[name](tree)
            if given.page:  # now, as the next part may take long, or end the program
                write_page(table())
    print("\n".join(["", *HEAD, *table()]))
    bad = sum(not row.good for row in ROWS)
    print(f"{len(ROWS) - bad} of {len(ROWS)} as expected, seed {given.seed}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
