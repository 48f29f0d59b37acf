"""What a result depends on besides its input files and the config: code, libraries, and the words for its variables."""

import ast
import json
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path

import rockdamp
from rockdamp.storage import dataset as storage

LIBRARIES = {"numba", "numpy", "scipy"}
PLUMBING = {"cli", "errors", "progress", "text"}  # they change no stored number


def code(module, script="dataset"):
    """Return params of a rule: ``solvers.newmark 3fa2c1d0`` for each module that its function and its script import.

    Comments and docstrings do not count. The versions of the libraries that these import come last.
    """
    digests, libraries, waiting = {}, set(), [script, f"rockdamp.{module}"]
    while waiting:
        name = waiting.pop()
        if name not in digests:
            digests[name], imported = _read(name)
            libraries |= LIBRARIES & {each.partition(".")[0] for each in imported}
            waiting += [
                each
                for each in imported
                if each[:9] == "rockdamp." and each.split(".")[1] not in PLUMBING
            ]
    modules = [
        f"{name.removeprefix('rockdamp.')} {digest}" for name, digest in sorted(digests.items())
    ]
    return [*modules, *(f"{name} {version(name)}" for name in sorted(libraries))]


def texts(dataset):
    """Return params of a rule: ``glossary: restitution 1d0c77ab`` for each name of its dataset, and for its title."""
    entries = {
        "title": storage.glossary()["datasets"][dataset]["title"],
        **storage.variables(dataset),
    }
    return [f"glossary: {name} {_digest(json.dumps(entry))}" for name, entry in entries.items()]


@cache
def _read(name):
    """Return the digest of a module or script, and the names of the modules that it imports."""
    file = _file(name) or Path(__file__).with_name(f"{name}.py")
    tree = ast.parse(file.read_text(encoding="utf-8"))
    imported = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            imported |= {each.name for each in node.names}
        elif isinstance(node, ast.ImportFrom):
            inside = {f"{node.module}.{each.name}" for each in node.names}
            imported |= {
                each if _file(each) else "rockdamp" if node.level else node.module
                for each in inside
            }
        elif isinstance(getattr(node, "body", None), list):
            node.body = [each for each in node.body if not _is_docstring(each)]
    if "rockdamp" in imported:
        raise ValueError(
            f"{file} imports from the package as a whole; it must name the module, from rockdamp on"
        )
    return _digest(ast.dump(tree)), imported


@cache
def _file(name):
    """Return the file of a module of the package, or None."""
    place = Path(rockdamp.__file__).parents[1].joinpath(*name.split("."))
    files = place.with_suffix(".py"), place / "__init__.py"
    return next((file for file in files if name.startswith("rockdamp.") and file.is_file()), None)


def _is_docstring(node):
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


def _digest(text):
    return sha256(text.encode()).hexdigest()[:8]
