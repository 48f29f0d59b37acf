"""Time a full rebuild of the chain, and the matching of all four studies: `.venv/bin/python benchmarks/rebuild.py`.

The rebuild goes to a folder of its own, which is removed again; the results of the tree stay as they are. The matching
is timed in this process, after the kernel is compiled: computation alone, without start-up, reading and writing.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import yaml

from rockdamp import decay, matching_studies
from rockdamp.curve import TrilinearCurve
from rockdamp.damping import Damping
from rockdamp.newmark import available_threads, solve

ROOT = Path(__file__).resolve().parents[1]


def rebuild(cores: int) -> float:
    """Seconds of wall time of a build from nothing."""
    with tempfile.TemporaryDirectory(dir=ROOT) as folder:
        results = Path(folder).name
        command = [sys.executable, "-m", "snakemake", "--cores", str(cores), "--quiet", "all"]
        start = time.perf_counter()
        subprocess.run([*command, "--config", f"results={results}"], cwd=ROOT, check=True)
        return time.perf_counter() - start


def match_all() -> float:
    """Seconds of wall time of the matching of every study."""
    config = yaml.safe_load((ROOT / "config/default.yaml").read_text(encoding="utf-8"))
    for damping in (Damping.cr(0.9), Damping("CDR", 0.05)):
        solve(TrilinearCurve(0.04, 0.85), damping, step=0.01, steps=1, release_amplitude=0.5)  # compiles
    total = 0.0
    for name in decay.STUDIES:
        decays = decay.study(name, config)
        start = time.perf_counter()
        matched = matching_studies.match(name, config, decays)
        seconds = time.perf_counter() - start
        total += seconds
        print(f"  {name:18s} {seconds:6.2f} s   {matched['damping_ratio'].size} damping ratios, each at two steps")
    return total


def main() -> None:
    """Print both figures with what they were measured on."""
    print(f"{platform.processor() or platform.machine()}, {os.cpu_count()} processors, {available_threads()} used;")
    print(f"Python {platform.python_version()}, NumPy {np.__version__}")
    print("matching of all studies, computation alone:")
    print(f"  together           {match_all():6.2f} s   (target: under 10 s)")
    print(f"full rebuild on 2 cores: {rebuild(2):6.1f} s   (target: under 90 s)")


if __name__ == "__main__":
    main()
