"""Rockdamp beside C and JAX loops, OpenSeesPy, SciPy and numba, and against its targets: one command, run by hand.

    .venv-peers/bin/python benchmarks/side_by_side.py [--quick] [--earthquakes] [--only SECTION ...]

Prints the tables and writes README.md and a plot beside this file; `--quick` tries everything out in small and
writes to build/benchmarks. Each ratio is between things measured in turn in the same run. A machine with nothing else
to do is needed, and no C compiler or OpenSeesPy has to be there: what needs them is left out.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
import traceback
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import answer
import growth
import kernel
import matplotlib
import pipeline
import psutil
from matplotlib.figure import Figure
from measure import Section
from peers import FLAGS, c_version

ROOT = Path(__file__).resolve().parents[1]
KEPT = ROOT / "build/benchmarks"  # what each section found last
COMMAND = ".venv-peers/bin/python benchmarks/side_by_side.py --earthquakes"
PACKAGES = ("numpy", "numba", "scipy", "snakemake", "openseespy", "jax")
GIBIBYTE = 2**30


def main() -> None:
    """Measure, print and write."""
    options = _options()
    folder = KEPT / "quick" if options.quick else Path(__file__).parent
    kept = KEPT / ("quick" if options.quick else "full")
    kept.mkdir(parents=True, exist_ok=True)
    everything = _sections(options)
    print(_machine())
    failed = [name for name in options.only or everything if not _measured(name, everything[name], options.quick, kept)]
    sections = [
        Section.of(json.loads(path.read_text(encoding="utf-8")))
        for path in (kept / f"{name}.json" for name in SECTIONS)
        if path.exists()
    ]
    text = _readme(sections)
    print(text)
    (folder / "README.md").write_text(text, encoding="utf-8")
    _plot(sections, folder)
    print(f"Written: README.md and the plot in {os.path.relpath(folder)}")
    if failed:
        sys.exit(f"These sections failed; what stands of them is from an earlier run, or nothing: {', '.join(failed)}")


SECTIONS = ("kernel", "answer", "pipeline", "cli", "memory", "growth", "earthquakes")


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="small sizes, to see that everything works")
    parser.add_argument("--earthquakes", action="store_true", help="also build the study of earthquakes from nothing")
    parser.add_argument(
        "--only",
        nargs="+",
        choices=SECTIONS,
        metavar="SECTION",
        help=f"measure these, and take the others from the last run here: {', '.join(SECTIONS)}",
    )
    options = parser.parse_args()
    options.earthquakes |= "earthquakes" in (options.only or ())
    return options


def _sections(options: argparse.Namespace) -> dict[str, Callable[[bool], Section]]:
    found: dict[str, Callable[[bool], Section]] = {
        "kernel": kernel.section,
        "answer": answer.section,
        "pipeline": pipeline.section,
        "cli": pipeline.command_line,
        "memory": growth.memory,
        "growth": growth.growth,
    }
    return {**found, "earthquakes": pipeline.earthquakes} if options.earthquakes else found


def _measured(name: str, measure: Callable[[bool], Section], quick: bool, kept: Path) -> bool:
    """Run a section and keep what it found; a failure costs that section alone."""
    print(f"{name} ...", flush=True)
    start = time.perf_counter()
    try:
        found = measure(quick)
    except Exception:
        traceback.print_exc()
        return False
    print(f"{name}: {time.perf_counter() - start:.0f} s", flush=True)
    (kept / f"{name}.json").write_text(json.dumps(found.data()), encoding="utf-8")
    return True


# --- what is written --------------------------------------------------------------------------------------------------


def _readme(sections: list[Section]) -> str:
    targets = [target for section in sections for target in section.targets]
    met = sum(target["met"] for target in targets)
    rows = [
        f"| {section.title} | {target['what']} | {target['target']} | {target['measured']} |"
        f" {'met' if target['met'] else '**not met**'} |"
        for section in sections
        for target in section.targets
    ]
    parts = [
        "# How fast it is",
        "Time and memory of rockdamp, beside C and JAX loops, OpenSeesPy, SciPy and a plain numba loop, and against"
        " targets. The command below writes this page.",
        f"```\n{COMMAND}\n```",
        "`make peers` sets up what the command needs. Without `--earthquakes` that study is not built anew."
        " `--only` measures a part anew, so parts may be of"
        " different runs. A part that was not measured is left out.",
        f"## Machine\n\n{_machine()}",
        f"## Targets\n\n{met} of {len(targets)} are met.",
        "\n".join(["| part | what | target | measured | |", "| --- | --- | --- | ---: | --- |", *rows]),
        "![Cost of a step](kernel.png)",
    ]
    for section in sections:
        parts += [f"## {section.title}", *(table.markdown() for table in section.tables), *section.notes]
    return "\n\n".join(parts) + "\n"


def _machine() -> str:
    versions = [f"Python {platform.python_version()}"]
    for name in PACKAGES:
        try:
            versions.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            versions.append(f"no {name}")
    memory = psutil.virtual_memory().total / GIBIBYTE
    return "\n".join(
        [
            f"- Processor: {_processor()}, {len(os.sched_getaffinity(0))} cores usable",
            f"- Memory: {memory:.0f} GiB; {platform.system()} on {platform.machine()}",
            f"- Load in the last quarter of an hour of measuring: {os.getloadavg()[2]:.1f}, its own included",
            f"- {', '.join(versions)}",
            f"- C: {c_version()}, `{' '.join(FLAGS)}`",
        ]
    )


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    fields: dict[str, str] = {}
    for line in lines:
        name, _, value = line.partition(":")
        fields.setdefault(name.strip(), value.strip())
    widest = next((name for name in ("avx512f", "avx2", "avx") if name in fields.get("flags", "").split()), "no AVX")
    return f"{fields.get('model name', platform.machine())} ({widest})"


def _plot(sections: list[Section], folder: Path) -> None:
    matplotlib.use("agg")
    by_title = {section.title: section for section in sections}
    if "Kernel" in by_title:
        _plot_kernel(by_title["Kernel"], folder / "kernel.png")


def _plot_kernel(section: Section, path: Path) -> None:
    figure = Figure(figsize=(11, 5.5), layout="constrained")
    axes = figure.subplots(2, 4, sharex=True, sharey=True)
    lines = {"rockdamp, 1 thread": 3, "rockdamp, 2 threads": 4, "C": 5, "plain numba": 6}
    for ax, name in zip(axes.flat, kernel.NAMES.values(), strict=False):  # one is left for the legend
        rows = [row for row in section.series["damping_force"] if row[:2] == [name, "record"]]
        for (label, column), style in zip(lines.items(), ("o-", "s-", "^--", "v:")[: len(lines)], strict=True):
            points = [(int(row[2]), float(row[column].split()[0])) for row in rows if row[column] != "-"]
            if points:
                ax.loglog(*zip(*points, strict=True), style, label=label, markersize=4)
        ax.set_title(name)
        ax.grid(alpha=0.3)
    for ax in axes[-1]:
        ax.set_xlabel("histories")
    for ax in axes[:, 0]:
        ax.set_ylabel("ns per step and history")
    for ax in axes.flat[len(kernel.NAMES) :]:
        ax.set_axis_off()
    axes[-1, -1].legend(*axes[0, 0].get_legend_handles_labels(), loc="center")
    figure.suptitle("Cost of a step under a record")
    figure.savefig(path, dpi=120)


if __name__ == "__main__":
    main()
