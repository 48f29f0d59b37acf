"""What a process of one command does with Python's garbage collector, and what a library leaves alone."""

import gc
import subprocess
import sys

from click.testing import CliRunner

from rockdamp.cli import main

PROGRAM = """
import atexit, gc
from rockdamp.process import OBJECTS, collect_rarely
atexit.register(lambda: print(gc.get_freeze_count() > 1000, gc.get_threshold()[0] == OBJECTS))
collect_rarely()
print(gc.get_freeze_count())
"""


def test_a_process_that_ends_soon_leaves_its_objects_out_of_the_last_collection():
    assert subprocess.check_output([sys.executable, "-c", PROGRAM], text=True).split() == ["0", "True", "True"]


def test_a_command_that_is_called_from_python_leaves_the_collector_as_it_is():
    before = gc.get_threshold()
    assert CliRunner().invoke(main, ["presets"]).exit_code == 0
    assert gc.get_threshold() == before
