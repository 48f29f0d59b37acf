"""A warm Python: what Snakemake and its jobs import of others is imported once, and each run forks from there.

Most of what a dry run, or a job of the minimal config, takes is that importing. Nothing of rockdamp is imported before
the fork, nor numba, which reads the environment: a run finds the package and the environment as they are by then.

    warm_python.py serve FOLDER        answers at FOLDER/socket until its standard input is closed
    warm_python.py ask FOLDER ...      runs `python ...` there, with the folder, environment and files of the caller
"""

import atexit
import gc
import json
import os
import select
import shutil
import socket
import subprocess
import sys
import tempfile
from functools import cache
from importlib import import_module
from pathlib import Path

IMPORTED = (
    "jsonschema matplotlib.backends.backend_agg matplotlib.backends.backend_pdf matplotlib.figure netCDF4 pandas "
    "scipy.integrate scipy.optimize scipy.special snakemake.cli snakemake.report snakemake.script xarray"
).split()
MUCH = 1 << 16  # bytes


@cache
def start():
    """Start one, which ends with this process; return its folder, in which `python` is a program that asks it."""
    folder = Path(tempfile.mkdtemp(prefix="warm-"))
    (folder / "python").write_text(f'#!/bin/sh\nexec "{sys.executable}" -S -E "{__file__}" ask "{folder}" "$@"\n')
    (folder / "python").chmod(0o755)
    command = [sys.executable, __file__, "serve", folder]
    alone = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}  # as the Snakefile has it: read when NumPy is imported
    server = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=alone)
    atexit.register(server.communicate)
    assert server.stdout.readline() == b"ready\n"
    return folder


def ask(folder, arguments, place, environment, files=(0, 1, 2)):
    """Run `python arguments` in a place, with these files as its standard ones; return its exit status."""
    with socket.socket(socket.AF_UNIX) as connection:
        connection.connect(f"{folder}/socket")
        socket.send_fds(connection, [b" "], files)
        connection.sendall(json.dumps([arguments, str(place), dict(environment)]).encode() + b"\n")
        return int(connection.recv(MUCH))


def serve(folder):
    for name in IMPORTED:
        import_module(name)
    sys.modules["snakemake.cli"].get_argument_parser()  # loads its plugins
    gc.collect()
    gc.freeze()  # what a fork does not look at is not copied for it
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(f"{folder}/socket")
        listener.listen()
        print("ready", flush=True)
        while sys.stdin not in select.select([listener, sys.stdin], [], [])[0]:
            connection, _ = listener.accept()
            if os.fork() == 0:
                if os.fork() == 0:  # whom nobody has to wait for
                    answer(connection, f"{folder}/python")
                os._exit(0)
            os.wait()
            connection.close()
    shutil.rmtree(folder)


def answer(connection, python):
    """Run what is asked for, and tell the exit status."""
    message, files, _, _ = socket.recv_fds(connection, MUCH, 3)
    while not message.endswith(b"\n"):
        message += connection.recv(MUCH)
    run = os.fork()
    if run == 0:
        for number, file in enumerate(files):
            os.dup2(file, number)
        become(python, *json.loads(message))
    connection.send(str(os.waitstatus_to_exitcode(os.waitpid(run, 0)[1])).encode())
    os._exit(0)


def become(python, arguments, place, environment):
    """Be the Python that is asked for, with `-m MODULE`, `-c CODE` or a script."""
    import runpy

    os.chdir(place)
    os.environ.clear()
    os.environ.update(environment)
    sys.executable = python
    option = arguments[0] if arguments[0] in ("-m", "-c") else ""
    sys.argv = arguments[bool(option) :]
    sys.path[:1] = [place if option else os.path.dirname(sys.argv[0]), *environment["PYTHONPATH"].split(os.pathsep)]
    if option == "-m":
        runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
    elif option == "-c":
        exec(compile(sys.argv[0], "<string>", "exec"), {"__name__": "__main__"})
    else:
        runpy.run_path(sys.argv[0], run_name="__main__")
    sys.exit()


if __name__ == "__main__":
    if sys.argv[1] == "serve":
        serve(sys.argv[2])
    else:
        sys.exit(ask(sys.argv[2], sys.argv[3:], os.getcwd(), os.environ))
