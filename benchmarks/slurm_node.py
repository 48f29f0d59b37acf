"""Debian's Slurm on this machine as one node, with its own key, sockets and ports."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

SLURM_ETC = Path("/etc/slurm")  # where Debian's Slurm is built to look
PACKAGES = {
    "munged": "munge",
    "mungekey": "munge",
    "slurmctld": "slurmctld",
    "slurmd": "slurmd",
    "squeue": "slurm-client",
    "unshare": "util-linux",
}
NODE = "rockdamp"
PATIENCE = 120.0  # s, for what takes seconds on an idle machine; then something is wrong
CORES = 2
CONFIGURATION = """
ClusterName={node}
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
ReturnToService=1
SchedulerParameters=sched_interval=2
NodeName={node} NodeHostname={host} NodeAddr=127.0.0.1 CPUs={cores} RealMemory={memory} State=UNKNOWN
PartitionName=all Nodes={node} Default=YES MaxTime=INFINITE State=UP
"""


class Failed(Exception):
    """What went wrong, in words for whoever started this."""


@contextmanager
def slurm(folder: Path) -> Iterator[None]:
    """Run munge and Slurm as one node, idle when the block starts."""
    for name, mode in {"etc": 0o755, "munge": 0o755, "state": 0o700, "spool": 0o755}.items():
        (folder / name).mkdir(mode=mode)
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2**20
    (folder / "etc/slurm.conf").write_text(
        CONFIGURATION.format(
            node=NODE,
            host=socket.gethostname().partition(".")[0],
            ports=free_ports(2),
            folder=folder,
            cores=CORES,
            memory=int(0.9 * memory),
        ),
        encoding="utf-8",
    )
    call("mount", "--bind", folder / "etc", SLURM_ETC)
    munge = folder / "munge"
    call("mungekey", "--create", "--keyfile", munge / "key")
    commands: list[list[str | Path]] = [
        [
            "munged",
            "--foreground",
            "--force",
            "--socket",
            munge / "socket",
            "--key-file",
            munge / "key",
            "--pid-file",
            munge / "pid",
            "--seed-file",
            munge / "seed",
        ],
        ["slurmctld", "-D"],
        ["slurmd", "-D", "-N", NODE],
    ]
    daemons = []
    try:
        for command in commands:
            daemons.append(daemon(command, folder))
            if command[0] == "munged":
                with_patience((munge / "socket").exists, "munged does not start")
        with_patience(lambda: node_state() == "idle", "the node does not become idle")
        yield
    except Failed:
        for log in sorted([*folder.glob("slurm*.log"), *folder.glob("*.out")]):
            print(f"\n{log}:\n" + "\n".join(log.read_text(encoding="utf-8").splitlines()[-8:]), file=sys.stderr)
        raise
    finally:
        for process in reversed(daemons):
            process.terminate()
            process.wait()


def daemon(command: list[str | Path], folder: Path) -> subprocess.Popen[bytes]:
    """Start a daemon in a session of its own, so that Ctrl-C does not reach it before those that use it."""
    with open(folder / f"{command[0]}.out", "wb") as output:
        return subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT, start_new_session=True)


def free_ports(count: int) -> list[int]:
    """Return ports of loopback that nobody listens on."""
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


def call(*command: str | Path) -> str:
    """Run a command; return what it prints."""
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode:
        raise Failed(f"{' '.join(map(str, command))} failed: {run.stderr.strip() or run.stdout.strip()}")
    return run.stdout


def node_state() -> str:
    """Return the state of the node; nothing as long as Slurm does not answer."""
    run = subprocess.run(["sinfo", "--noheader", "--format=%T"], capture_output=True, text=True)
    return run.stdout.strip()


def jobs() -> dict[str, tuple[str, str]]:
    """Return state and rule of every job that Slurm knows."""
    lines = call("squeue", "--noheader", "--states=all", "--format=%i|%T|%k").splitlines()
    return {line.split("|")[0]: (line.split("|")[1], line.split("|")[2]) for line in lines}


def in_state(*states: str) -> list[str]:
    """Return the shares that are in one of the states."""
    return [job for job, (state, rule) in jobs().items() if state in states and "population_share" in rule]


def update_node(*changes: str) -> None:
    """Change the node as its administrator does."""
    call("scontrol", "update", f"NodeName={NODE}", *changes)


def with_patience(condition: Callable[[], object], otherwise: str | None = None) -> None:
    """Wait until something is the case; if it never is, fail where there is something to say."""
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            if otherwise is None:
                return
            raise Failed(otherwise)
        time.sleep(0.2)
