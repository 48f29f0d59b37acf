"""Commands as users mistype them, with what they mean: lists, outputs, raw tables, priors, and records of tests.

Each command runs in this process. It holds if it gives the right answer, or ends with status 2 and writes nothing.
"""

from __future__ import annotations

import json
import os
import random
from collections.abc import Callable, Iterator
from pathlib import Path
from unittest import mock

import numpy as np
from attacks import ANSWER, REFUSED, Attack
from click.testing import CliRunner, Result

import rockdamp as rd
from rockdamp.cli import main
from rockdamp.laboratory import identify
from rockdamp.laboratory.prior import Prior
from rockdamp.vocabulary import STANDARD_GRAVITY

SIZE = ["--thickness", "0.3", "--height", "3"]
WALL = [*SIZE, "--preset", "new", "--restitution", "0.85"]
TIME = np.round(0.01 * np.arange(120), 10)
MOTION = np.round(2.0 * np.sin(7.0 * TIME) * np.exp(-TIME), 9)
WITHIN = 1e-9  # relative, of numbers that are only read and converted


def _folder(folder: Path) -> dict[str, bytes]:
    """Return what lies in a folder: links by what they lead to, files by their bytes."""
    return {
        str(path.relative_to(folder)): os.readlink(path).encode() if path.is_symlink() else path.read_bytes()
        for path in folder.rglob("*")
        if path.is_symlink() or path.is_file()
    }


def _judged(
    folder: Path,
    arguments: list[str],
    right: Callable[[Result], str],
    may: tuple[str, ...] = (),
    means: bool = False,
) -> str:
    """Run a command and return how it ended.

    `right` tells of an answer what is wrong with it, or ``""``. The files that `may` change are named; what `means`
    something must be answered.
    """
    before = _folder(folder)
    result = CliRunner().invoke(main, arguments)
    if result.exit_code == 2 and isinstance(result.exception, SystemExit):
        if _folder(folder) != before:
            return "refused, and something was written"
        if result.stdout or "Error:" not in result.stderr or "Traceback" in result.stderr:
            return f"refused without an error: {result.output[-200:]}"
        return f"refused what means something: {result.stderr[-200:]}" if means else REFUSED
    if result.exit_code != 0:
        return f"status {result.exit_code}: {type(result.exception).__name__}: {str(result.exception)[:200]}"
    changed = {name for name, content in before.items() if _folder(folder).get(name) != content}
    if changed - {*may}:
        return f"overwrote {', '.join(sorted(changed))}"
    return right(result) or ANSWER


def _record(path: Path) -> Path:
    rd.write_record(path, rd.Record(TIME, MOTION, header={"synthetic": "yes"}))
    return path


# --- lists ------------------------------------------------------------------------------------------------------------

TARGETS = {  # options, and units with their size in SI
    "--to-pga": {"": 1.0, "g": STANDARD_GRAVITY, "cm/s2": 0.01, "m/s^2": 1.0, " gal": 0.01},
    "--to-pgv": {"": 1.0, "cm/s": 0.01, "m/s": 1.0, " in/s": 0.0254, "mm s-1": 0.001},
    "--scale": {"": 1.0},
}
NOTATIONS = ["{:.4f}", "{:.3e}", "{:.3E}", "{:+.3f}", "{:g}", " {:.2f} "]
SLIPS: list[Callable[[str], str]] = [
    lambda text: text.replace(".", "_", 1) if "." in text else f"{text}_0",
    lambda text: text.replace("1", "\u0661").replace("2", "\uff12") + "\u0660",
    lambda text: f"{text},",
    lambda text: f"{text},,1",
    lambda text: "0,85",
    lambda text: f"{text}:1",
    lambda text: f"{text}e",
    lambda text: f"{text} kg",
    lambda text: f"{text};1",
    lambda text: f"1:0.1:{text}",
    lambda text: f"{text},nan",
    lambda text: f"{text},1e999",
    lambda text: "",
]


def _list(rng: random.Random, folder: Path) -> str:
    option, units = rng.choice(list(TARGETS.items()))
    unit, size = rng.choice(list(units.items()))
    texts = [rng.choice(NOTATIONS).format(rng.uniform(0.1, 3)) for _ in range(rng.randrange(1, 4))]
    if rng.random() < 0.3:
        start, step, count = rng.randrange(1, 9), rng.randrange(1, 5), rng.randrange(1, 4)
        numbers = [start + step * i for i in range(count + 1)]
        form = rng.choice(["{:g}", "{:.1e}", "{:.2f}"])
        text = ":".join(form.format(number / 10) for number in (start, numbers[-1], step)) + unit
        meant = [size * number / 10 for number in numbers]
    else:
        text = ",".join(texts).rstrip() + unit
        meant = [size * float(each) for each in texts]
    slip = rng.random() < 0.5
    if slip:
        text = rng.choice(SLIPS)(text)
    key = {"--to-pga": "pga", "--to-pgv": "pgv", "--scale": "scale"}[option]

    def right(result: Result) -> str:
        rows = json.loads(result.stdout)
        rows = rows if isinstance(rows, list) else [rows]
        values = [row[key] for row in rows] if key in rows[0] else [row["pga"] / np.abs(MOTION).max() for row in rows]
        same = len(values) == len(meant) and np.allclose(values, meant, rtol=WITHIN, atol=0)
        return "an answer to what means nothing" if slip else "" if same else f"{text!r} is read as {values}"

    arguments = ["respond", "--record", str(_record(folder / "a.csv")), *WALL, f"{option}={text}", "--json"]
    return _judged(folder, arguments, right, means=not slip)


# --- outputs ----------------------------------------------------------------------------------------------------------


def _output(rng: random.Random, folder: Path) -> str:
    records = folder / "recs"
    records.mkdir()
    for name in ("a.csv", "b.csv"):
        _record(records / name)
    (folder / "link.csv").symlink_to(records / "a.csv")
    (folder / "hard.csv").hardlink_to(records / "b.csv")
    (folder / "linked").symlink_to(records)
    (folder / "dangling.csv").symlink_to(folder / "nowhere" / "x.csv")
    (folder / "earlier.csv").write_text("old\n", encoding="utf-8")
    (folder / "folder.csv").mkdir()
    named = rng.choice(["recs", "recs/*.csv", "recs/[ab].csv", "**/?.csv", "recs/a.csv", "linked", "link.csv"])
    sources = ["recs/a.csv", "link.csv"] if named in ("recs/a.csv", "link.csv") else None
    bad = ["folder.csv", "none/x.csv", f"{300 * 'x'}.csv", os.fsdecode(b"caf\xe9.csv"), "x.txt", ""]
    inputs = ["recs/a.csv", "recs/../recs/b.csv", "link.csv", "hard.csv", "linked/b.csv"]
    target = rng.choice([*bad, *inputs, *inputs, "earlier.csv", "new.csv", "recs/new.csv", "dangling.csv"])
    reads = target in inputs and not (sources and ("b.csv" in target or target == "hard.csv"))
    walls = folder / "walls.csv"
    walls.write_text("id,thickness,height,preset\na,0.3,3,new\n", encoding="utf-8")
    if rng.random() < 0.5:
        arguments = ["respond", "--record", named, *WALL, "--to-pga", "1,2", "--csv", target]
    else:
        arguments = ["batch", str(walls), "--records", named, "--pgv", "0.3", "--output", target]

    def right(_: Result) -> str:
        return "an output that must be refused" if target in bad or reads else ""

    before = Path.cwd()
    os.chdir(folder)
    try:
        resolved = os.path.relpath(os.path.realpath(target), folder.resolve()) if target and target not in bad else ""
        return _judged(folder, arguments, right, may=() if reads else (target, resolved))
    finally:
        os.chdir(before)


# --- raw tables -------------------------------------------------------------------------------------------------------


CELLS = {"nan": "nan", "long": 140000 * "1", "underscore": "1_0", "digits": "\u0661", "control": "1\x07"}


def _raw(rng: random.Random, folder: Path) -> str:
    """A table of a motion after rest, as some logger writes it, or damaged."""
    count = rng.choice([3, 8, 15, 16, 40, 200])
    elapsed = np.round(0.01 * np.arange(count), 10)
    at = elapsed - elapsed[count // 3]
    motion = np.where(at > 0, np.sin(25 * at), 0.0)
    factor, unit = rng.choice([(STANDARD_GRAVITY, "g"), (0.01, "cm/s2"), (1.0, "m/s^2"), (0.01, "Gal")])
    mark = rng.choice([",", ";", "\t", " "])
    decimal = "," if mark in ";\t" and rng.random() < 0.5 else "."
    rows = [[f"{t:.6f}", f"{a / factor:.9e}"] for t, a in zip(elapsed, motion, strict=True)]
    damage = rng.choice([*20 * [""], "nan", "lost", "cell", "long", "gap", "back", "underscore", "digits", "control"])
    row = rng.randrange(1, count)
    if damage == "cell":
        del rows[row][1]
    elif damage == "gap":
        rows[row:] = [[f"{float(t) + 1:.6f}", a] for t, a in rows[row:]]
    elif damage == "back":
        rows[row][0] = rows[row - 1][0]
    elif damage == "lost":
        rows[row][1] = ""
    elif damage:
        rows[row][1] = CELLS[damage]
    lines = [mark.join(cells).replace(".", decimal) for cells in rows]
    lines = [*rng.choice([[], ["# made by hand"], ["Logger 3", ""]]), *rng.choice([[mark.join("ta")], []]), *lines]
    text = rng.choice(["", "\ufeff"]) + rng.choice(["\n", "\r\n"]).join(lines) + rng.choice(["", "\n"])
    path = folder / "raw.dat"
    path.write_bytes(text.encode())
    arguments = ["record", str(path), "--time", "1:s", "--table-acceleration", f"2:{unit}", "--baseline", "none"]
    rest = rng.choice([*9 * [f"{0.01 * (count // 3):g}"], "0", "-1", "9", "nan", "1_0"])
    arguments += [f"--rest={rest}", "--output", str(folder / "out.csv")]
    lowpass = rng.choice([*8 * [None], 1e-9, 1e-3, 20.0, 49.99, 50.0, 1e9, -1.0])
    rate = rng.choice([*8 * [None], 1e-9, 1.0, 40.0, 200.0, 3e6, 1e12, 0.0])
    for name, value in (("--lowpass", lowpass), ("--rate", rate)):
        arguments += [] if value is None else [f"{name}={value!r}"]
    plain = lowpass is None and rate is None and rest.startswith("0.") and not damage

    def right(_: Result) -> str:
        made = rd.read_record(folder / "out.csv").ground_acceleration
        if damage:
            return f"an answer to a damaged table: {damage}"
        if plain and not np.allclose(made, motion, rtol=0, atol=1e-7):
            return "another motion than the table's"
        return "" if np.abs(made).max() < 2 else "a motion beyond the table's"

    return _judged(folder, arguments, right, means=plain)


# --- priors -----------------------------------------------------------------------------------------------------------

SECTIONS = ["yield_displacement_ratio", "strength_ratio", "restitution", "sensor_deviation", "order"]


class _Reached(Exception):
    """The posterior was asked for, with this prior."""


def _prior(rng: random.Random, folder: Path) -> str:
    path, name = folder / "priors.yaml", rng.choice(SECTIONS)
    low, high = round(rng.uniform(0.05, 0.1), 4), round(rng.uniform(0.5, 0.9), 4)
    kind = rng.choice(["uniform", "loguniform"])
    good = f"{name}: {{distribution: {kind}, low: {low}, high: {high}}}\n"
    bad = [
        f"{good}{good}",
        good.replace(str(low), str(2 * high)),
        good.replace(str(low), ".nan"),
        good.replace(str(high), ".inf"),
        good.replace(str(low), "-.inf"),
        good.replace(str(low), "0.0_5"),
        good.replace(str(low), "'0.05'"),
        good.replace(str(low), "[0.05]"),
        good.replace(name, f"{name}s"),
        good.replace(kind, "gauss"),
        good.replace("low:", "lo:"),
        good.replace("}", ", mean: 0.3}"),
        f"- {good}",
        f"prior:\n  {good}",
        "a: " + 5000 * "[" + 5000 * "]",
        "\t: {",
        "a: !!python/name:os.system",
        "&a [*a]",
        f"# caf\xe9\n{good}".encode("latin-1"),
        f"{good}\0".encode(),
        b"\xff\xfe" + good.encode("utf-16-le"),
        "sensor_zero: -1.0\n",
        "sensor_drift: .inf\n",
        "",
    ]
    how = rng.choice(["good", "good", "bad", "bad", "bad", "bad", "fifo", "folder", "none"])
    if how == "fifo":
        os.mkfifo(path)
    elif how == "folder":
        path.mkdir()
    elif how != "none":
        text = good if how == "good" else rng.choice(bad)
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
    reached: list[Prior] = []

    def posterior(*_: object, prior: Prior, **others: object) -> None:
        reached.append(prior)
        raise rd.InputError("the prior was read")

    record = str(_record(folder / "a.csv"))
    with mock.patch.object(identify, "posterior", posterior):
        ended = _judged(
            folder, ["calibrate", "--record", record, *SIZE, "--posterior", "--priors", str(path)], lambda _: "it ended"
        )
    if ended != REFUSED or not reached:
        return ended if how != "good" else f"a prior that is one is refused: {good}"
    stated = getattr(reached[0], name)
    if how != "good":
        return f"a prior that is none is taken: {path.read_bytes()!r}"
    return ANSWER if (stated.distribution, stated.low, stated.high) == (kind, low, high) else f"it is read as {stated}"


# --- records of tests -------------------------------------------------------------------------------------------------

STANDARD_ERRORS, CLOSE = 6.0, 0.02  # an estimate is right within so many of its errors and this of e


def _test(rng: random.Random, folder: Path) -> str:
    """A wall on a shaking table, with noise, offset and drift, or with a slip in what is told of it."""
    numbers = np.random.default_rng(rng.randrange(2**32))
    e, a1, b1 = rng.uniform(0.7, 0.95), rng.uniform(0.03, 0.1), rng.uniform(0.6, 0.85)
    wall = rd.Wall(rng.uniform(0.1, 0.3), rng.uniform(2.0, 4.0), overburden_ratio=rng.choice([0.0, 1.0]))
    rate, period = rng.choice([100.0, 200.0, 256.0]), rng.uniform(0.3, 1.0)
    elapsed = np.arange(int(rate * 5)) / rate
    at = np.pi * (elapsed - 1.0) / period
    onset = float(wall.rocking_onset(b1))
    motion = rng.uniform(0.8, 3.0) * onset * np.where((at > -3) & (at < 3), (1 - 2 * at**2) * np.exp(-(at**2)), 0.0)
    run = {"wall": wall, "curve": rd.TrilinearCurve(a1, b1), "damping": rd.Damping.cr(e)}
    response = rd.respond(record=rd.Record(elapsed, motion), **run)
    moved = np.nan_to_num(response.displacement.values, nan=float(wall.instability_displacement))
    noise = 10.0 ** rng.uniform(-6, -3.5)
    moved = moved + noise * numbers.standard_normal(elapsed.size) + rng.uniform(-1, 1) * 1e-3 * (1 + elapsed / 5)
    slip = rng.choice(["", "", "", "", "", "short", "no rest", "constant", "zero motion"])
    if slip == "short":
        elapsed, motion, moved = elapsed[:5], motion[:5], moved[:5]
    elif slip == "no rest":
        start = int(rate)
        elapsed, motion, moved = elapsed[start:] - elapsed[start], motion[start:], moved[start:]
    elif slip == "constant":
        moved = np.full(moved.size, 0.01)
    elif slip == "zero motion":
        motion = 0.0 * motion
    path = folder / "test.csv"
    rd.write_record(path, rd.Record(elapsed, motion, moved, header={"specimen": "w"}))
    arguments = ["calibrate", "--record", str(path), f"--thickness={wall.thickness}", f"--height={wall.height}"]
    arguments += [f"--overburden-ratio={wall.overburden_ratio}", "--json"]

    def right(result: Result) -> str:
        rows = json.loads(result.stdout)
        rows = rows["parameters"] if isinstance(rows, dict) else rows
        (row,) = (row for row in rows if row["parameter"] == "restitution")
        if slip in ("constant", "zero motion"):
            return f"an answer to {slip}"
        allowed = STANDARD_ERRORS * row["standard_error"] + CLOSE
        off = abs(row["estimate"] - e)
        return "" if slip or off < allowed else f"e = {e:.4f} is estimated as {row['estimate']:.4f}, +- {allowed:.4f}"

    return _judged(folder, arguments, right)


KINDS = {"lists": _list, "outputs": _output, "raw tables": _raw, "priors": _prior, "records of tests": _test}


def command_attacks(seed: int, kind: str) -> Iterator[Attack]:
    """Yield attacks of one of the `KINDS` without end."""
    for number in range(2**31):
        name = f"{kind} {number}, seed {seed}"
        yield Attack(name, lambda folder, number=number: KINDS[kind](random.Random(f"{seed} {kind} {number}"), folder))
