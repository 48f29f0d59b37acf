"""Write records of ESM (.ASC) and of K-NET or KiK-net (.EW, .NS, .EW2, ...) as CSVs that rockdamp reads, beside them.

Run it as `python examples/convert_records.py FILE ...`. A file of ESM has lines `KEY: value`, then one acceleration a
line in cm/s^2. One of K-NET has a header up to the line `Memo.`, whose names take 18 characters, then counts; times
the scale factor they are in gal, and their mean is taken off.
"""

import re
import sys
from pathlib import Path

import numpy as np

import rockdamp as rd


def esm(lines):
    """Return the step [s] and the accelerations [m s-2] of a file of ESM."""
    header = dict(line.split(":", 1) for line in lines if ":" in line)
    if header["UNITS"].strip() != "cm/s^2":
        raise ValueError(f"UNITS is {header['UNITS'].strip()!r}; it must be cm/s^2")
    values = np.array([float(line) for line in lines if line.strip() and ":" not in line])
    return float(header["SAMPLING_INTERVAL_S"]), values / 100


def knet(lines):
    """Return the step [s] and the accelerations [m s-2] of a file of K-NET or KiK-net."""
    first = next(number for number, line in enumerate(lines) if line.startswith("Memo")) + 1
    header = {line[:18].strip(): line[18:].strip() for line in lines[:first]}
    gal, counts = map(float, re.findall(r"[\d.]+", header["Scale Factor"]))
    values = np.array(" ".join(lines[first:]).split(), dtype=float) * gal / counts / 100
    return 1 / float(header["Sampling Freq(Hz)"].removesuffix("Hz")), values - values.mean()


def convert(path):
    """Write a record beside its file, with the ending .csv, and return the path."""
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    step, values = knet(lines) if lines and lines[0].startswith("Origin Time") else esm(lines)
    written = path.with_name(f"{path.name}.csv" if path.suffix.lower() != ".asc" else f"{path.stem}.csv")
    rd.write_record(written, rd.Record(step * np.arange(values.size), values, header={"source": path.name}))
    return written


if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    for name in sys.argv[1:]:
        try:
            print(convert(Path(name)), "written")
        except (KeyError, StopIteration, ValueError, OSError) as error:
            sys.exit(f"{name}: this is no record of ESM or K-NET that is read here ({error})")
