"""Find the sources and the part of the config that a result depends on, to store and to watch both.

Modules are read, not run, and their imports followed wherever they stand. A file of the package that a module names in
a string, as ``variables.yaml``, belongs to that module.
"""

from __future__ import annotations

import ast
import hashlib
import json
import re
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

PACKAGE = __name__.partition(".")[0]
ROOT = Path(__file__).resolve().parents[1]
BY_NAME = re.compile(r"""import_module\(f"(\w+\.[\w.]+)\.\{""")
FILE_NAME = re.compile(r"""(["'])([\w./-]*\.\w+)\1""")


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
        waiting += [*(".".join(parts[:end]) for end in range(2, len(parts))), *_imports(name, path)]
    return dict(sorted(modules.items()))


def files_of(*names: str) -> list[Path]:
    """Return the files that `names` depend on: their modules and the files of the package that those name."""
    files = set()
    for path in modules_of(*names).values():
        files |= {path, *_data_files(path)}
    return sorted(files)


def code_version(*names: str) -> str:
    """Return the version of the package and a digest of every file that `names` depend on.

    The digest covers names and contents, so it is the same wherever the package lies.
    """
    return version_of(files_of(*names))


def version_of(paths: Iterable[Path]) -> str:
    """Return the version of the package and a digest of these files of it, as they are now."""
    digest = hashlib.sha256()
    for path in sorted(paths):
        content = path.read_bytes()
        digest.update(f"{path.relative_to(ROOT).as_posix()}\0{len(content)}\0".encode() + content)
    return f"{version(PACKAGE)}+{digest.hexdigest()[:16]}"


def config_digest(part: Mapping[str, Any]) -> str:
    """Return the SHA-256 of a part of the config; the order of its keys does not matter.

    What JSON cannot hold, as NaN, an infinity or a date, raises `ValueError`.
    """
    try:
        text = json.dumps(part, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    except TypeError as error:
        raise ValueError(f"the config cannot be digested: {error}") from None
    return hashlib.sha256(text.encode()).hexdigest()


def subset(whole: Mapping[str, Any], *keys: str) -> dict[str, Any]:
    """Return the part of the config that dotted `keys` name, nested as it was; an unknown key raises `KeyError`."""
    part: dict[str, Any] = {}
    for key in keys:
        *sections, last = key.split(".")
        source: Any = whole
        target = part
        for section in sections:
            source, target = source[section], target.setdefault(section, {})
        target[last] = source[last]
    return part


@cache
def _file_of(name: str) -> Path | None:
    place = ROOT.joinpath(*name.split(".")[1:])
    for path in (place / "__init__.py", place.with_suffix(".py")):
        if name.split(".")[0] == PACKAGE and path.is_file():
            return path
    return None


@cache
def _imports(name: str, path: Path) -> frozenset[str]:
    """Return the package's modules that one module imports."""
    here = name if path.name == "__init__.py" else name.rpartition(".")[0]
    imported = set()
    for node in ast.walk(ast.parse(_text(path), filename=str(path))):
        if isinstance(node, ast.Import):
            wanted = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(here.split(".")[: len(here.split(".")) - node.level + 1]) if node.level else ""
            base = ".".join(part for part in (base, node.module) if part)
            # `from package import name` takes a module where there is one, else what the package's __init__ defines.
            modules = [f"{base}.{alias.name}" for alias in node.names]
            wanted = [module if _file_of(module) else base for module in modules]
        else:
            continue
        for target in wanted:
            if target.split(".")[0] == PACKAGE and _file_of(target):
                imported.add(target)
    for package in BY_NAME.findall(_text(path)):  # any of its modules
        imported |= {f"{package}.{file.stem}" for file in ROOT.joinpath(*package.split(".")[1:]).glob("[!_]*.py")}
    return frozenset(imported)


@cache
def _data_files(path: Path) -> frozenset[Path]:
    names = {match[2] for match in FILE_NAME.finditer(_text(path))}
    named = {(folder / name).resolve() for folder in (ROOT, path.parent) for name in names}
    return frozenset(file for file in named if file.suffix != ".py" and file.is_relative_to(ROOT) and file.is_file())


@cache
def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8")
