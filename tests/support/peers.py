"""Other software that tests compare with; they are skipped where it is missing."""

import importlib
import sys

import pytest
from repository import ROOT


def opensees():
    """Return OpenSeesPy, or skip the module where it or a library of the system is missing."""
    try:
        return importlib.import_module("openseespy.opensees")
    except (ImportError, RuntimeError, OSError) as problem:
        pytest.skip(f"OpenSeesPy cannot be imported: {problem}", allow_module_level=True)


def example(folder, name):
    """Return a module of `examples`, which stands beside others that it imports."""
    sys.path.insert(0, str(ROOT / "examples" / folder))
    try:
        return importlib.import_module(name)
    finally:
        sys.path.pop(0)
