"""Find the science and the part of the config that a result depends on, to store and to watch both.

Modules are read, not run, and their imports followed wherever they stand. What counts of a module is its code without
docstrings, comments and the words of its errors and warnings, so that an edit of these makes nothing run again. A file
of the package that a module names in a string, as ``glossary.yaml``, belongs to that module. Of the glossary, the
entries of a dataset's own names count.
"""

from __future__ import annotations

import ast
import hashlib
import json
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

from rockdamp.storage import glossary

PACKAGE = __name__.partition(".")[0]
ROOT = Path(__file__).resolve().parents[1]
BY_NAME = re.compile(r"""import_module\(f"(\w+\.[\w.]+)\.\{""")
FILE = re.compile(r"[\w./-]*\.\w+")
WORDS = ("require", "warn")  # functions whose arguments name and explain what is wrong

# Modules that change no value of a result, with the reason. What they import counts.
NO_SCIENCE = {
    "rockdamp.errors": "raises and prints",
    "rockdamp.plausibility": "refuses or warns; what passes is as it was given",
    "rockdamp.stated": "warns of what passes as it was given",
    "rockdamp.questions": "warns of what passes as it was given",
    "rockdamp.progress": "shows how far a job is",
    "rockdamp.storage.atomic": "writes the bytes that it is given",
    "rockdamp.storage.provenance": "finds what counts",
    "rockdamp.storage.glossary": "reads the glossary, of which a dataset's own names count",
}
# Numbers in words. Stages need them for errors alone; figures, pages and claims show them.
NUMBERS_IN_WORDS = ("rockdamp.text",)


def modules_of(*names: str) -> dict[str, Path]:
    """Return the modules of the package that `names` import, directly or not, themselves included, with their files.

    The ``__init__`` of the package itself only passes names on. It counts where a module takes such a name from it. A
    module that the package does not have raises `ModuleNotFoundError`.
    """
    modules: dict[str, Path] = {}
    waiting = list(names)
    while waiting:
        name = waiting.pop()
        if name in modules:
            continue
        path = _file_of(name)
        if path is None:
            raise ModuleNotFoundError(f"{PACKAGE} has no module {name!r}", name=name)
        modules[name] = path
        parts = name.split(".")  # the packages on the way to a module, but the outermost, are run too
        waiting += [*(".".join(parts[:end]) for end in range(2, len(parts))), *_read(name, path).imports]
    return dict(sorted(modules.items()))


@cache
def code_version(*names: str, dataset: str = "", without: tuple[str, ...] = ()) -> str:
    """Return the version of the package and a digest of the science that `names` depend on.

    The digest covers names and contents, so it is the same wherever the package lies. It takes in what the glossary
    says of a kind of `dataset`, and leaves out the modules `without` and those of `NO_SCIENCE`.
    """
    modules = modules_of(*names)
    parts: dict[str, bytes] = {}
    for name, path in modules.items():
        if name not in NO_SCIENCE and name not in without:
            module = _read(name, path)
            parts[name] = module.science
            parts |= {file.relative_to(ROOT).as_posix(): file.read_bytes() for file in module.data_files}
    if dataset:
        said = glossary.read()["datasets"][dataset]["title"], glossary.variables(dataset)
        parts["glossary"] = json.dumps(said, sort_keys=True).encode()
    digest = hashlib.sha256()
    for name, content in sorted(parts.items()):
        digest.update(f"{name}\0{len(content)}\0".encode() + content)
    return f"{version(PACKAGE)}+{digest.hexdigest()[:16]}"


@dataclass(frozen=True)
class Sources:
    """What a job computes with: modules, the kind of dataset that it writes, and modules that it needs for words."""

    modules: tuple[str, ...]
    dataset: str = ""
    without: tuple[str, ...] = ()

    def version(self) -> str:
        """Return their version, as `code_version` does."""
        return code_version(*self.modules, dataset=self.dataset, without=self.without)


def edited_since(moment: float) -> bool:
    """Say whether a file of the package was changed, or put in its place, since a moment [s]."""
    for folder, subfolders, names in os.walk(ROOT):
        subfolders[:] = [name for name in subfolders if name != "__pycache__"]
        if any(os.stat(Path(folder, name)).st_ctime >= moment for name in names):
            return True
    return False


def config_digest(part: Mapping[str, Any]) -> str:
    """Return the SHA-256 of a part of the config; the order of its keys does not matter.

    What JSON cannot hold, as NaN, an infinity or a date, raises `ValueError`.
    """
    try:
        text = json.dumps(part, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    except TypeError as error:
        raise ValueError(f"the config cannot be digested: {error}") from None
    return hashlib.sha256(text.encode()).hexdigest()


class _Module(NamedTuple):
    imports: frozenset[str]
    data_files: frozenset[Path]
    science: bytes


@cache
def _file_of(name: str) -> Path | None:
    place = ROOT.joinpath(*name.split(".")[1:])
    for path in (place / "__init__.py", place.with_suffix(".py")):
        if name.split(".")[0] == PACKAGE and path.is_file():
            return path
    return None


@cache
def _read(name: str, path: Path) -> _Module:
    """Read one module once: what it imports of the package, the files that it names, and its science."""
    text = path.read_text(encoding="utf-8")
    tree = ast.parse(text, filename=str(path))
    nodes = list(ast.walk(tree))
    here = name if path.name == "__init__.py" else name.rpartition(".")[0]
    imports = {module for node in nodes for module in _imported(node, here)}
    for package in BY_NAME.findall(text):  # any of its modules
        imports |= {f"{package}.{file.stem}" for file in ROOT.joinpath(*package.split(".")[1:]).glob("[!_]*.py")}
    strings = {node.value for node in nodes if isinstance(node, ast.Constant) and isinstance(node.value, str)}
    named = {
        (folder / string).resolve() for folder in (ROOT, path.parent) for string in filter(FILE.fullmatch, strings)
    }
    files = {file for file in named if file.suffix != ".py" and file.is_relative_to(ROOT) and file.is_file()}
    for node in nodes:
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) and _has_docstring(
            node
        ):
            node.body = node.body[1:] or [ast.Pass()]
    for node in nodes:
        _silence(node)
    return _Module(frozenset(imports), frozenset(files), ast.unparse(tree).encode())


def _imported(node: ast.AST, here: str) -> set[str]:
    """Return the package's modules that a statement in a module of the package `here` imports."""
    if isinstance(node, ast.Import):
        wanted = [alias.name for alias in node.names]
    elif isinstance(node, ast.ImportFrom):
        base = ".".join(here.split(".")[: len(here.split(".")) - node.level + 1]) if node.level else ""
        base = ".".join(part for part in (base, node.module) if part)
        # `from package import name` takes a module where there is one, else what the package's __init__ defines.
        modules = [f"{base}.{alias.name}" for alias in node.names]
        wanted = [module if _file_of(module) else base for module in modules]
    else:
        return set()
    return {target for target in wanted if target.split(".")[0] == PACKAGE and _file_of(target)}


def _has_docstring(node: ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    return bool(node.body) and isinstance(node.body[0], ast.Expr) and _is_text(node.body[0].value)


def _silence(node: ast.AST) -> None:
    """Take the words of an error or a warning out of the statement that raises it."""
    if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
        node.exc = node.exc.func
    if isinstance(node, ast.Call) and getattr(node.func, "attr", getattr(node.func, "id", "")) in WORDS:
        node.args = [value for value in node.args if not _is_text(value)]
        node.keywords = [keyword for keyword in node.keywords if not _is_text(keyword.value)]


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str))
