"""Write records of ESM, K-NET, KiK-net and CSMIP as CSV files that rockdamp reads.

Run it as `python examples/convert_records.py FILE ...`. Each CSV is written into the folder of its
file.

- ESM (.ASC): lines `KEY: value`, then one acceleration a line in cm/s^2.
- K-NET and KiK-net (.EW, .NS, ...): a header up to the line `Memo.`, whose names take 18
  characters, then counts. Counts times the scale factor are in gal; their mean is subtracted.
- CSMIP (.V2): accelerations below a line `N points of accel data equally spaced at S sec, in
  cm/sec2`.
"""

import re
import sys
from pathlib import Path

import numpy as np

import rockdamp as rd

CSMIP_HEAD = re.compile(
    r"\s*(\d+) points of accel data equally spaced at\s*([\d.]+) sec, in cm/sec(2|/sec)"
)


def read_esm(lines):
    """Return the step [s], the accelerations [m s-2] and their stated number."""
    header = dict(line.split(":", 1) for line in lines if ":" in line)
    unit = header["UNITS"].strip()
    if unit != "cm/s^2":
        raise ValueError(f"UNITS is {unit!r}; it must be cm/s^2")
    values = np.array([float(line) for line in lines if line.strip() and ":" not in line])
    return float(header["SAMPLING_INTERVAL_S"]), values / 100, int(header.get("NDATA", values.size))


def read_knet(lines):
    """Return the step [s], the accelerations [m s-2] and their number, which no file states."""
    first = next(index for index, line in enumerate(lines) if line.startswith("Memo")) + 1
    header = {line[:18].strip(): line[18:].strip() for line in lines[:first]}
    frequency = float(header["Sampling Freq(Hz)"].removesuffix("Hz"))
    gal, counts = map(float, re.findall(r"[\d.]+", header["Scale Factor"]))
    values = np.array(" ".join(lines[first:]).split(), dtype=float) * gal / counts / 100
    return 1 / frequency, values - values.mean(), values.size


def read_csmip(lines):
    """Return the step [s], the accelerations [m s-2] and their stated number."""
    first = next(index for index, line in enumerate(lines) if CSMIP_HEAD.match(line)) + 1
    number, step, _ = CSMIP_HEAD.match(lines[first - 1]).groups()
    texts = []
    for line in lines[first:]:
        if re.search("[a-z&]", line):  # the head of velocities, or the end of the file
            break
        texts += line.split()
    return float(step), np.array(texts, dtype=float) / 100, int(number)


def convert(path):
    """Write a record beside its file, with the ending .csv, and return the path."""
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    suffix = path.suffix.lower()
    read = read_esm
    if lines and lines[0].startswith("Origin Time"):
        read = read_knet
    elif suffix == ".v2":
        read = read_csmip
    try:
        step, values, number = read(lines)
    except (KeyError, StopIteration):
        raise ValueError(
            "no record of ESM, K-NET or CSMIP; write elapsed_s,ground_acceleration_m_s2"
        ) from None
    if values.size != number:
        raise ValueError(f"it has {values.size} accelerations and states {number}")
    # Files of K-NET differ in their suffixes alone.
    target = path.with_suffix(".csv") if suffix == ".asc" else path.with_name(f"{path.name}.csv")
    elapsed = step * np.arange(values.size)
    rd.write_record(target, rd.Record(elapsed, values, header={"source": path.name}))
    return target


if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    for name in sys.argv[1:]:
        try:
            print(convert(Path(name)), "written")
        except (ValueError, OSError) as error:
            sys.exit(f"{name}: {error}")
