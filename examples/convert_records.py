"""Write records of ESM (.ASC), K-NET or KiK-net (.EW, .NS, ...) and CSMIP (.V2) as CSVs that rockdamp reads.

Run it as `python examples/convert_records.py FILE ...`. A file of ESM has lines `KEY: value`, then one acceleration a
line in cm/s^2. One of K-NET has a header up to the line `Memo.`, whose names take 18 characters, then counts; times
the scale factor they are in gal, and their mean is taken off. A .V2 has a line `N points of accel data equally spaced
at S sec, in cm/sec2` before the accelerations. A CSV stands beside its file.
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
    require_count(values, header.get("NDATA", values.size))
    vertical(header.get("STREAM", "").strip().endswith("Z"))
    return float(header["SAMPLING_INTERVAL_S"]), values / 100


def knet(lines):
    """Return the step [s] and the accelerations [m s-2] of a file of K-NET or KiK-net."""
    first = next(number for number, line in enumerate(lines) if line.startswith("Memo")) + 1
    header = {line[:18].strip(): line[18:].strip() for line in lines[:first]}
    gal, counts = map(float, re.findall(r"[\d.]+", header["Scale Factor"]))
    values = np.array(" ".join(lines[first:]).split(), dtype=float) * gal / counts / 100
    vertical(header.get("Dir.", "").startswith("U"))
    return 1 / float(header["Sampling Freq(Hz)"].removesuffix("Hz")), values - values.mean()


def v2(lines):
    """Return the step [s] and the accelerations [m s-2] of a file of CSMIP."""
    stated = re.compile(r"\s*(\d+) points of accel data equally spaced at\s*([\d.]+) sec, in cm/sec(2|/sec)")
    at, found = next((at, found) for at, line in enumerate(lines) if (found := stated.match(line)))
    end = next((end for end in range(at + 1, len(lines)) if re.search("[a-z&]", lines[end])), len(lines))
    values = np.array(" ".join(lines[at + 1 : end]).split(), dtype=float)
    require_count(values, found[1])
    return float(found[2]), values / 100


def require_count(values, stated):
    """Refuse a file that was cut off."""
    if values.size != int(stated):
        raise ValueError(f"it has {values.size} accelerations and states {int(stated)}")


def vertical(is_vertical):
    """Warn of a vertical component: a wall rocks under the horizontal ones."""
    if is_vertical:
        print("warning: this is a vertical component; a wall rocks under the horizontal ones", file=sys.stderr)


def convert(path):
    """Write a record beside its file, with the ending .csv, and return the path."""
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    read = knet if lines and lines[0].startswith("Origin Time") else v2 if path.suffix.lower() == ".v2" else esm
    step, values = read(lines)
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
            sys.exit(f"{name}: this is no record of ESM, K-NET or CSMIP that is read here ({error})")
