"""Record files, of which it is known what they mean: an answer that differs from it is found out."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from attacks import ANSWER, REFUSED, Attack

import rockdamp as rd
from rockdamp.vocabulary import STANDARD_GRAVITY

TIME = np.round(0.01 * np.arange(120), 10)
MOTION = np.round(2.0 * np.sin(7.0 * TIME) * np.exp(-TIME), 9)  # m/s2
UNITS = {
    "m s-2": 1.0,
    "m/s2": 1.0,
    "m/s^2": 1.0,
    "cm s-2": 0.01,
    "cm/s2": 0.01,
    "gal": 0.01,
    "g": STANDARD_GRAVITY,
    "mm s-2": 0.001,
    "in/s2": 0.0254,
    "furlong": None,
    "": None,
}
COLUMN_UNITS = {"m_s2": 1.0, "cm_s2": 0.01, "g": STANDARD_GRAVITY, "in_s2": None, "": None, "m": None}
NO_NUMBERS = ["", "nan", "inf", "1_0", "٣", "0x1p3", "1,5", "1.2.3", "--1", "1e999", "one", "1 2", "\x00", "１"]
BYTES = [b"", b"\n", b",", b"#", b":", b'"', b"\x00", b"\xff", b"\xef\xbb\xbf", b"9" * 400, b"\r", b" ", b"e", b"-"]


class Meant(NamedTuple):
    """A file's bytes and suffix, and the accelerations that it means; None where it means nothing."""

    content: bytes
    suffix: str
    motion: np.ndarray | None
    synthetic: bool | None = None


def _csv(rows: list[list[str]] | None = None, unit: str = "m_s2", header: tuple[str, ...] = (), end: str = "\n") -> str:
    rows = rows if rows is not None else _rows()
    column = "ground_acceleration" + (f"_{unit}" if unit else "")
    return end.join([*header, f"elapsed_s,{column}", *map(",".join, rows)]) + end


def _rows(motion: np.ndarray = MOTION) -> list[list[str]]:
    return [[f"{t:.10g}", f"{a:.10g}"] for t, a in zip(TIME, motion, strict=True)]


def _meant(text: str, motion: np.ndarray | None, synthetic: bool | None = None) -> Meant:
    return Meant(text.encode("utf-8", "surrogatepass"), ".csv", motion, synthetic)


def _column_unit(rng: random.Random) -> Meant:
    unit, factor = rng.choice(list(COLUMN_UNITS.items()))
    return _meant(_csv(unit=unit), None if factor is None else factor * MOTION)


def _stated_unit(rng: random.Random) -> Meant:
    unit, factor = rng.choice(list(UNITS.items()))
    key = rng.choice(["units", "Units", "UNITS", " units "])
    text = _csv(header=(f"# {key}: s, {unit}{rng.choice(['', ' ', ', m'])}",))
    return _meant(text, None if factor is None else factor * MOTION)


def _rows_moved(rng: random.Random) -> Meant:
    rows, at = _rows(), rng.randrange(1, TIME.size - 2)
    how = rng.choice(["lost", "twice", "swapped", "late"])
    if how == "lost":
        del rows[at]
    elif how == "twice":
        rows.insert(at, rows[at])
    elif how == "swapped":
        rows[at], rows[at + 1] = rows[at + 1], rows[at]
    else:
        rows[at][0] = f"{TIME[at] + 0.01 * rng.uniform(0.01, 0.99):.10g}"
    return _meant(_csv(rows), None)


def _no_number(rng: random.Random) -> Meant:
    rows = _rows()
    rows[rng.randrange(TIME.size)][rng.randrange(2)] = rng.choice(NO_NUMBERS)
    return _meant(_csv(rows), None)


def _another_writer(rng: random.Random) -> Meant:
    """The same record as other programs would write it."""
    text = _csv(end=rng.choice(["\n", "\r\n"]))
    how = rng.choice(["bom", "spaces", "blank lines", "columns swapped", "utf-16", "digits", "comment at the end"])
    if how == "bom":
        text = "\ufeff" + text
    elif how == "spaces":
        text = text.replace(",", " , ")
    elif how == "blank lines":
        text += "\n" * rng.randrange(1, 4)
    elif how == "columns swapped":
        text = "\n".join(",".join(line.split(",")[::-1]) for line in text.splitlines()) + "\n"
    elif how == "utf-16":
        return Meant(text.encode("utf-16"), ".csv", MOTION)
    elif how == "digits":
        text = _csv([[f"{t:.17e}", f"{a:.17e}"] for t, a in zip(TIME, MOTION, strict=True)])
    else:
        text += "# end\n"
    return _meant(text, MOTION)


def _synthetic(rng: random.Random) -> Meant:
    key = rng.choice(["synthetic", "Synthetic", "SYNTHETIC", "synthetic "])
    answer = rng.choice(["yes", "Yes", "YES", "no", "true", "1", "maybe", "", "yes, made up"])
    header = [f"# {key}{rng.choice([': ', ':', ' = ', ' : '])}{answer}"]
    if rng.random() < 0.3:
        header.append("# synthetic: no")
    told = {answer.lower() for answer in (answer, "no" if len(header) > 1 else answer)}
    truth = {frozenset({"yes"}): True, frozenset({"no"}): False}.get(frozenset(told))
    return _meant(_csv(header=tuple(header)), MOTION, truth)


def _at2(rng: random.Random) -> Meant:
    unit, factor = rng.choice(
        [
            ("G", STANDARD_GRAVITY),
            ("CM/S2", 0.01),
            ("CM/S**2", 0.01),
            ("M/S2", 1.0),
            ("IN/S2", 0.0254),
            ("PARSEC", None),
        ]
    )
    step, right = rng.choice(
        [("0.0100", True), (".01", True), ("1.0D-02", True), ("1.E-2", True), ("10. MSEC", True), ("1/100", True)]
        + [("0,01", False), ("-0.01", False), ("0", False), ("ten", False)]
    )
    count = TIME.size + rng.choice([0, 0, 0, -1, 1])
    values = MOTION / (factor or 1.0)
    body = "\n".join(" ".join(f"{value: .9E}" for value in values[at : at + 5]) for at in range(0, TIME.size, 5))
    head = f"PEER\nSomewhere\nACCELERATION TIME SERIES IN UNITS OF {unit}\n"
    text = f"{head}NPTS= {count}, DT= {step}{'' if 'SEC' in step else ' SEC'}\n{body}\n"
    means = factor is not None and right and count == TIME.size
    return Meant(text.encode(), ".AT2", MOTION if means else None)


def _edited(rng: random.Random) -> Meant:
    """Bytes changed anywhere: whatever is read must be finite and uniform."""
    made = rng.choice([_column_unit, _at2, _synthetic])(rng)
    content = made.content
    for _ in range(rng.randrange(1, 5)):
        at = rng.randrange(len(content) + 1)
        content = content[:at] + rng.choice(BYTES) + content[at + rng.randrange(8) :]
    return Meant(content, made.suffix, np.array([]))


WRITERS = (_column_unit, _stated_unit, _rows_moved, _no_number, _another_writer, _synthetic, _at2, _edited)


def record_attacks(seed: int) -> Iterator[Attack]:
    """Yield record files, of which it is known what they mean."""
    rng = random.Random(seed)
    while True:
        writer = rng.choice(WRITERS)
        yield Attack(f"record:{writer.__name__}", _reader(writer(rng)))


def _reader(meant: Meant) -> Callable[[Path], str]:
    def run(folder: Path) -> str:
        path = folder / f"record{meant.suffix}"
        path.write_bytes(meant.content)
        try:
            record = rd.read_record(path)
        except rd.InputError as error:
            return REFUSED if path.name in str(error) else f"refused without the file's name: {error}"
        return _judged(record, meant)

    return run


def _judged(record: rd.Record, meant: Meant) -> str:
    found = record.ground_acceleration
    if not (np.isfinite(found).all() and np.isfinite(record.step) and record.step > 0):
        return "an answer that is not finite"
    if meant.motion is None:
        return "an answer to what means nothing"
    if meant.motion.size:
        if found.shape != meant.motion.shape or not np.allclose(found, meant.motion, rtol=1e-6, atol=1e-9):
            return "another motion than the file's"
        if abs(record.step - 0.01) > 1e-9:
            return "another step than the file's"
    if meant.synthetic is not None and record.synthetic is not meant.synthetic:
        return "another label than the file's"
    return ANSWER
