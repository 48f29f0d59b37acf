"""The package, the pipeline and the tools use public names of other packages alone: private ones change unannounced."""

import ast

import pytest
from repository import ROOT

FILES = sorted(path for folder in ("src", "workflow", "tools") for path in (ROOT / folder).rglob("*.py"))
PRIVATE = ("numba.core", "_thread")  # modules that are private whatever their names
# Where a private name is used all the same, and why no public one does it.
EXCEPTIONS: dict[str, str] = {}


def is_private(name):
    return name.startswith("_") and not name.startswith("__")


def private_names(tree):
    """Yield the private names of other packages that a module imports or reaches for, and changes of `sys.modules`."""
    modules = {}  # names that stand for modules of other packages
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield from _of_path(alias.name)
                modules[alias.asname or alias.name.partition(".")[0]] = alias.name
        elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0 and node.module != "__future__":
            if node.module.partition(".")[0] == "rockdamp":
                continue
            for alias in node.names:
                yield from _of_path(f"{node.module}.{alias.name}")
                modules[alias.asname or alias.name] = f"{node.module}.{alias.name}"
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and is_private(node.attr):
            root = node.value
            while isinstance(root, ast.Attribute | ast.Call):
                root = root.value if isinstance(root, ast.Attribute) else root.func
            if isinstance(root, ast.Name) and root.id in modules and not modules[root.id].startswith("rockdamp"):
                yield ast.unparse(node)
        if isinstance(node, ast.Subscript | ast.Call) and ast.unparse(node).startswith(
            ("sys.modules[", "sys.modules.setdefault(", "sys.modules.update(", "sys.modules.pop(")
        ):
            yield ast.unparse(node)


def _of_path(path):
    if path.startswith(PRIVATE) or any(map(is_private, path.split("."))):
        yield path


def found():
    for path in FILES:
        name = path.relative_to(ROOT).as_posix()
        for private in private_names(ast.parse(path.read_text(encoding="utf-8"))):
            yield name, private


def test_no_private_name_of_another_package_is_used():
    assert {f"{name}: {private}" for name, private in found() if name not in EXCEPTIONS} == set()
    assert set(EXCEPTIONS) <= {name for name, _ in found()}  # each exception still is one
    assert not any(name.startswith("src/rockdamp/storage/") for name in EXCEPTIONS)


@pytest.mark.parametrize(
    "code",
    [
        "import _thread",
        "from numba.core import caching",
        "import numba; numba.core._cache",
        "from numpy._core import umath",
        "import xarray as xr; xr.Dataset()._variables",
        "import sys; sys.modules['pint'] = None",
        "import sys; sys.modules.setdefault('pint', None)",
    ],
)
def test_a_private_name_is_seen(code):
    assert list(private_names(ast.parse(code)))


@pytest.mark.parametrize("code", ["from rockdamp.x import _y", "import numpy as np; np.__version__", "self._x = 1"])
def test_what_is_ones_own_is_not(code):
    assert not list(private_names(ast.parse(code)))
