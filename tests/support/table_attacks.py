"""Tables of walls with a slip in them. The writer of each knows what every row means."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from attacks import ANSWER, REFUSED, Attack
from record_attacks import BYTES, NO_NUMBERS

import rockdamp as rd
from rockdamp.assessment.table import COLUMNS, SIZES, BadRow, Row, read_walls
from rockdamp.plausibility import HIGHEST, THICKEST
from rockdamp.vocabulary import PRESETS

IDS = ["north", "a, b", "müller", "7", 'the "old" one', "x" * 80, "=1+1", "$HOME"]
Cells = dict[str, str]


class Meant(NamedTuple):
    """A table's bytes, and what each row means: its id, and its cells or None of one that makes no wall.

    `rows` is None of a table that must be refused, and empty where nobody knows what it means.
    """

    content: bytes
    rows: list[tuple[str, Cells | None]] | None


def table_attacks(seed: int) -> Iterator[Attack]:
    """Yield tables of walls with a slip in a row or in the header, or written as other programs do."""
    rng = random.Random(seed)
    while True:
        writer = rng.choice(WRITERS)
        yield Attack(f"table:{writer.__name__}", _judge(writer(rng)))


# --- tables ----------------------------------------------------------------------------------------------------------


def _number(rng: random.Random, low: float, high: float) -> str:
    value = rng.uniform(low, high)
    return rng.choice([f"{value:.6g}", f"{value:.6e}", f"+{value:.6g}", f" {value:.6g} "])


def _wall(rng: random.Random, name: str) -> Cells:
    """The cells of a wall that can rock."""
    thickness = _number(rng, 0.1, 0.6)
    cells = {"id": name, "thickness": thickness, "height": _number(rng, 6 * float(thickness), 20 * float(thickness))}
    shape = rng.choice(["parapet", "hinge_ratio", ""])
    if shape:
        cells[shape] = rng.choice(["yes", "TRUE", "1"]) if shape == "parapet" else _number(rng, 0.5, 0.9)
    if rng.random() < 0.5:
        cells["preset"] = rng.choice(list(PRESETS))
    else:
        cells |= {"a1": _number(rng, 0.01, 0.1), "b1": _number(rng, 0.6, 0.85)}
    if rng.random() < 0.5:
        cells["restitution"] = rng.choice([_number(rng, 0.5, 1), "analytical", "impulsive"])
    if rng.random() < 0.3:
        cells["density"] = _number(rng, 1200, 2400)
    return cells


def _walls(rng: random.Random) -> list[Cells]:
    return [_wall(rng, name) for name in rng.sample(IDS, 3)]


def _text(rng: random.Random, walls: list[Cells], sign: str = ",") -> str:
    """A CSV of walls, its columns in any order."""
    there = [name for name in COLUMNS if any(name in cells for cells in walls)]
    names = rng.sample(there, len(there))
    lines = [names, *([cells.get(name, "") for name in names] for cells in walls)]
    return "\n".join(sign.join(map(_quoted, line)) for line in lines) + "\n"


def _quoted(cell: str) -> str:
    return '"' + cell.replace('"', '""') + '"' if set(cell) & set(',;"') else cell


def _means(walls: list[Cells], bad: int | None = None) -> list[tuple[str, Cells | None]]:
    return [(cells["id"].strip(), None if at == bad else cells) for at, cells in enumerate(walls)]


def _as_meant(rng: random.Random) -> Meant:
    walls = _walls(rng)
    return Meant(_text(rng, walls).encode(), _means(walls))


def _no_number(rng: random.Random) -> Meant:
    walls, at = _walls(rng), rng.randrange(3)
    key = rng.choice([key for key in walls[at] if key in (*SIZES, "a1", "b1", "restitution")])
    odd = [*NO_NUMBERS, "25cm", "240 mm", "9.8ft", "0,25", "-0.2", "0"]
    walls[at][key] = rng.choice([each for each in odd if each.strip("\x00")])
    return Meant(_text(rng, walls).encode(), _means(walls, at))


def _slip(rng: random.Random) -> Meant:
    walls, at = _walls(rng), rng.randrange(1, 3)
    cells = walls[at]
    slips: list[Cells] = [
        {"thickness": cells["height"], "height": cells["thickness"]},
        {"thickness": ""},
        {"height": ""},
        {"id": ""},
        {"id": walls[0]["id"]},
        {"preset": "old", "a1": "", "b1": ""},
        {"preset": "new", "a1": "0.04", "b1": "0.85"},
        {"preset": "", "a1": "0.04", "b1": ""},
        {"preset": "", "a1": "0.04", "b1": "0.99"},
        {"restitution": "1.2"},
        {"restitution": "high"},
        {"parapet": "maybe"},
        {"parapet": "yes", "hinge_ratio": "0.6"},
        {"softening": "soft"},
        {"eccentricity": "1"},
    ]
    walls[at] = {**cells, **rng.choice(slips)}
    return Meant(_text(rng, walls).encode(), _means(walls, at))


def _in_millimetres(rng: random.Random) -> Meant:
    """Sizes that no wall has: read, and doubted."""
    walls, factor = _walls(rng), rng.choice([1000, 100, 39.37, 1e4])
    walls[1] |= {name: f"{factor * float(walls[1][name]):.6g}" for name in ("thickness", "height")}
    return Meant(_text(rng, walls).encode(), _means(walls))


def _cells_lost(rng: random.Random) -> Meant:
    walls, at = _walls(rng), rng.randrange(3)
    walls[at]["id"] = "lost"
    lines = _text(rng, walls).splitlines()
    lines[at + 1] += rng.choice([",", ",,1", ",0.3"])
    return Meant("\n".join(lines).encode(), _means(walls, at))


def _another_writer(rng: random.Random) -> Meant:
    """The same table as other programs would write it."""
    walls = _walls(rng)
    text = _text(rng, walls)
    forms = ["\ufeff" + text, text.replace("\n", "\r\n"), text.replace("\n", "\n\n"), text.rstrip("\n")]
    return Meant(rng.choice(forms).encode(), _means(walls))


def _no_table(rng: random.Random) -> Meant:
    walls = _walls(rng)
    text = _text(rng, walls)
    first, _, rest = text.partition("\n")
    forms = [text.replace("thickness", "thicknes", 1), f"{first},id\n{rest}", rest, _text(rng, walls, ";"), ""]
    forms += [text + '"cut', text.replace(",", "\x00,", 1)]
    coded = [*(form.encode() for form in forms), text.encode("utf-16"), (text + "ü").encode("latin-1")]
    return Meant(rng.choice(coded), None)


def _edited(rng: random.Random) -> Meant:
    """Bytes changed anywhere: whatever is read must be a wall."""
    content = rng.choice([_as_meant, _no_number, _slip])(rng).content
    for _ in range(rng.randrange(1, 5)):
        at = rng.randrange(len(content) + 1)
        content = content[:at] + rng.choice(BYTES) + content[at + rng.randrange(8) :]
    return Meant(content, [])


WRITERS = (_as_meant, _no_number, _slip, _in_millimetres, _cells_lost, _another_writer, _no_table, _edited)


# --- how they end ----------------------------------------------------------------------------------------------------


def _judge(meant: Meant) -> Callable[[Path], str]:
    def run(folder: Path) -> str:
        path = folder / "walls.csv"
        path.write_bytes(meant.content)
        try:
            rows = read_walls(path)
        except rd.InputError as error:
            if meant.rows:
                return f"a table of {len(meant.rows)} walls is refused: {error}"
            return REFUSED if path.name in str(error) else f"refused without the file's name: {error}"
        return _judged(rows, meant.rows)

    return run


def _judged(rows: list[Row | BadRow], meant: list[tuple[str, Cells | None]] | None) -> str:
    if meant is None:
        return "an answer to what is no table"
    if meant and [row.id for row in rows] != [name for name, _ in meant]:
        return "other rows than the table's"
    for at, row in enumerate(rows):
        if isinstance(row, BadRow):
            if not row.error.startswith(f"line {row.line}: ") or (meant and meant[at][1] is not None):
                return f"{row.error!r} of a good row, or without its line"
            continue
        sizes = np.array([getattr(row.wall, name) for name in ("thickness", "height", "density")], dtype=float)
        if not (np.isfinite(sizes).all() and 0 < row.restitution <= 1):
            return "an answer that is no wall"
        if (row.wall.thickness > THICKEST or row.wall.height > HIGHEST) and not row.doubts:
            return "a wall of another unit passes"
        if meant and (cells := meant[at][1]) is None:
            return "an answer to a row that makes no wall"
        if meant and not _is_made(row, cells):
            return "another wall than the row's"
    return REFUSED if any(isinstance(row, BadRow) for row in rows) else ANSWER


def _is_made(row: Row, cells: Cells) -> bool:
    """Whether a row holds the numbers of its cells."""
    a1, b1 = float(row.curve.yield_displacement_ratio), float(row.curve.strength_ratio)
    own = {name: getattr(row.wall, name, None) for name in SIZES} | {"a1": a1, "b1": b1}
    same = [own[name] == float(cells[name]) for name in own if name in cells]
    if "preset" in cells:
        curve = rd.TrilinearCurve.preset(cells["preset"])
        same += [(a1, b1) == (curve.yield_displacement_ratio, curve.strength_ratio)]
    if cells.get("restitution", "a")[0] in "+ 0123456789":
        same += [row.restitution == float(cells["restitution"])]
    return all(same) and isinstance(row.wall, rd.Parapet) == ("parapet" in cells)
