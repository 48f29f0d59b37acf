"""Other software that tests compare with: a test is skipped only where the software itself is missing."""

import importlib
import sys

import pytest
from repository import ROOT


def opensees():
    """OpenSeesPy."""
    try:
        return importlib.import_module("openseespy.opensees")
    except (
        ImportError,
        RuntimeError,
        OSError,
    ) as problem:  # absent, or without its system libraries
        pytest.skip(f"OpenSeesPy cannot be imported: {problem}", allow_module_level=True)


def example(folder, name):
    """A module of `examples`, which stands beside others that it imports."""
    sys.path.insert(0, str(ROOT / "examples" / folder))
    try:
        return importlib.import_module(name)
    finally:
        sys.path.pop(0)
