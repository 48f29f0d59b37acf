"""Write records of ESM (.ASC), K-NET or KiK-net (.EW, .NS, ...) and CSMIP (.V2) as CSVs that
rockdamp reads.

Run it as `python examples/convert_records.py FILE ...`. A file of ESM has lines `KEY: value`, then
one acceleration a line in cm/s^2. One of K-NET has a header up to the line `Memo.`, whose names
take 18 characters, then counts; times the scale factor they are in gal, and their mean is taken
off. A .V2 has a line `N points of accel data equally spaced at S sec, in cm/sec2` before the
accelerations. A CSV stands beside its file.
"""

import re
import sys
from pathlib import Path

import numpy as np

import rockdamp as rd


def esm(lines):
    """Return the step [s], the accelerations [m s-2] and their number as stated, of a file of ESM."""
    header = dict(line.split(":", 1) for line in lines if ":" in line)
    if header["UNITS"].strip() != "cm/s^2":
        raise ValueError(f"UNITS is {header['UNITS'].strip()!r}; it must be cm/s^2")
    values = np.array([float(line) for line in lines if line.strip() and ":" not in line])
    return float(header["SAMPLING_INTERVAL_S"]), values / 100, int(header.get("NDATA", values.size))


def knet(lines):
    """Return step, accelerations and their number from a file of K-NET or KiK-net, which states none."""
    first = next(number for number, line in enumerate(lines) if line.startswith("Memo")) + 1
    header = {line[:18].strip(): line[18:].strip() for line in lines[:first]}
    gal, counts = map(float, re.findall(r"[\d.]+", header["Scale Factor"]))
    values = np.array(" ".join(lines[first:]).split(), dtype=float) * gal / counts / 100
    return (
        1 / float(header["Sampling Freq(Hz)"].removesuffix("Hz")),
        values - values.mean(),
        values.size,
    )


def v2(lines):
    """Return the step, the accelerations and their number as stated, of a file of CSMIP."""
    head = re.compile(
        r"\s*(\d+) points of accel data equally spaced at\s*([\d.]+) sec, in cm/sec(2|/sec)"
    )
    at, found = next((at, found) for at, line in enumerate(lines) if (found := head.match(line)))
    end = next(
        (end for end in range(at + 1, len(lines)) if re.search("[a-z&]", lines[end])), len(lines)
    )
    values = np.array(" ".join(lines[at + 1 : end]).split(), dtype=float)
    return float(found[2]), values / 100, int(found[1])


def convert(path):
    """Write a record beside its file, with the ending .csv, and return the path."""
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    read = (
        knet
        if lines and lines[0].startswith("Origin Time")
        else v2
        if path.suffix.lower() == ".v2"
        else esm
    )
    try:
        step, values, number = read(lines)
    except (KeyError, StopIteration):
        raise ValueError(
            "no record of ESM, K-NET or CSMIP; write elapsed_s,ground_acceleration_m_s2"
        ) from None
    if values.size != number:
        raise ValueError(f"it has {values.size} accelerations and states {number}")
    written = path.with_name(
        f"{path.name}.csv" if path.suffix.lower() != ".asc" else f"{path.stem}.csv"
    )
    rd.write_record(
        written, rd.Record(step * np.arange(values.size), values, header={"source": path.name})
    )
    return written


if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    for name in sys.argv[1:]:
        try:
            print(convert(Path(name)), "written")
        except (ValueError, OSError) as error:
            sys.exit(f"{name}: {error}")
