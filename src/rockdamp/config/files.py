"""The files of a config: merged as Snakemake merges them, where in them a value stands, and what is wrong with it."""

from __future__ import annotations

import argparse
import difflib
import os
import re
import subprocess
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from rockdamp import units
from rockdamp.config.kinds import Refusal
from rockdamp.errors import InputError, shown
from rockdamp.plausibility import per_cent
from rockdamp.storage import yaml_file
from rockdamp.storage.yaml_file import KeyPath, dotted, get

COMMAND_LINE = "the command line"
SUFFIXES = (".yaml", ".yml", ".json")  # of a config

# --- reading ---------------------------------------------------------------------------------------------------------


def merged(files: Iterable[str | Path], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the config of `files`, of which a later one replaces values of an earlier one, with `values` over all.

    The values are as Snakemake takes them from ``--config``, which leaves what is nested as text.
    """
    config: dict[str, Any] = {}
    for document in (*map(_read, files), _restated(values)):
        _update(config, document)
    return config


def _read(file: str | Path) -> Mapping[str, Any]:
    document = yaml_file.read(file)
    if not isinstance(document, Mapping):
        raise InputError(f"{file}: is not a mapping of keys to values; a config must be one")
    return document


def _restated(value: Any) -> Any:
    """A value of the command line: its texts are what they are in a file, such as null or a number."""
    if isinstance(value, Mapping):
        return {key: _restated(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [_restated(inner) for inner in value]
    if not isinstance(value, str):
        return value
    words: dict[str, Any] = {"null": None, "~": None, "true": True, "false": False}
    if value in words:
        return words[value]
    try:
        return int(value) if re.fullmatch(r"[-+]?\d+", value) else units.number(value)
    except ValueError:
        return value


def _update(config: dict[str, Any], other: Mapping[str, Any]) -> None:
    for key, value in other.items():
        if isinstance(value, Mapping):
            inner = config.get(key)
            config[key] = inner = dict(inner) if isinstance(inner, Mapping) else {}
            _update(inner, value)
        else:
            config[key] = value


def refuse_unreadable(arguments: Sequence[str]) -> None:
    """End the program with one line where Snakemake would end in a traceback on a config file, or not name it.

    Snakemake reads the files of ``--configfile`` before the Snakefile. The profiles, which it reads first, call this
    with the arguments of its command line. Of ``--config`` Snakemake takes 0.8_5 for a number, as Python does.
    """
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("--configfile", "--configfiles", nargs="+", type=Path, default=[])
    parser.add_argument("--config", "-C", nargs="+", default=[])
    given = parser.parse_known_args(arguments)[0]
    for file in given.configfile:
        try:
            _read(file)
        except InputError as error:
            target = file.suffix.lower() not in SUFFIXES
            hint = "; --configfile takes every name that follows it: name targets before it" if target else ""
            raise SystemExit(f"Error: {error}{hint}") from None
    for key, _, value in (entry.partition("=") for entry in given.config):
        if _is_number(float, value) and not _is_number(units.number, value):
            raise SystemExit(f"Error: --config {key} is {value!r}; a number must have plain digits and no underscore")


def _is_number(read: Callable[[str], float], text: str) -> bool:
    try:
        read(text)
    except ValueError:
        return False
    return True


# --- where a value stands --------------------------------------------------------------------------------------------


def origin(path: KeyPath, config: Mapping[str, Any], files: Sequence[str | Path]) -> str:
    """Return the file and line of the value at `path` of the merged `config`, or of its section without such a key.

    The last of the `files` that has the key gives its value, or the last part of its section; a value that the files
    together do not give is of the command line.
    """
    stated = _at(config, path)
    if stated is not None and _at(merged(files, {}), path) != stated:
        return COMMAND_LINE
    for depth in [len(path)] if stated is not None else range(len(path) - 1, 0, -1):
        for file in reversed(files):
            line = yaml_file.line_of(file, path[:depth])
            if line is not None:
                return f"{file}, line {line}"
    return COMMAND_LINE


def _at(config: Any, path: KeyPath) -> str | None:
    try:
        return repr(get(config, path))  # not the value: NaN does not equal itself
    except LookupError:
        return None


# --- folders of results ----------------------------------------------------------------------------------------------

PARTS = ("src", "tests", "tools", "docs", "data", "config", "workflow", "profiles", "examples", "benchmarks", "logs")


def require_own_folder(folder: str | os.PathLike[str], tree: str | os.PathLike[str]) -> None:
    """Raise `InputError` if results would overwrite the project in the folder `tree`, or files that git tracks.

    The project's part ``results`` alone is allowed. Links are followed.
    """
    there, root = Path(folder).resolve(), Path(tree).resolve()
    allowed = "results need a folder of their own, such as results/my-wall"
    if root.is_relative_to(there):
        raise InputError(f"results is {os.fspath(folder)!r}, which holds the project; {allowed}")
    if there.is_relative_to(root):
        part = there.relative_to(root).parts[0]
        if part.startswith(".") or part in PARTS:
            raise InputError(f"results is {os.fspath(folder)!r}, in {part!r} of the project; {allowed}")
    tracked = [name for name in _tracked(there) if there / name != root / "results/README.md"]
    if tracked:
        raise InputError(f"results is {os.fspath(folder)!r}, where git tracks {tracked[0]!r}; {allowed}")


def refuse_braces(paths: Iterable[str | os.PathLike[str]]) -> None:
    """Raise `InputError` for a name with braces, which Snakemake takes for wildcards."""
    for path in paths:
        if set("{}") & set(os.fspath(path)):
            raise InputError(
                f"{os.fspath(path)}: has braces in its name, which Snakemake takes for wildcards; rename it"
            )


def _tracked(folder: Path) -> list[str]:
    """The files below a folder that git tracks; none where there is no git, or it cannot tell."""
    if not folder.is_dir():
        return []
    try:
        command = ["git", "-C", str(folder), "ls-files", "-z"]
        run = subprocess.run(command, capture_output=True, timeout=10, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return []
    return [os.fsdecode(name) for name in run.stdout.split(b"\0") if name] if run.returncode == 0 else []


def require_folders(folder: str | os.PathLike[str], below: Iterable[str], what: str) -> None:
    """Raise `InputError` unless `folder` and the folders `below` it are folders, or can be made."""
    for name in ("", *below):
        place = _nearest(Path(folder, name))
        if not place.is_dir():
            raise _unfit(place, what)


def require_writable(folder: str | os.PathLike[str], what: str) -> None:
    """Raise `InputError` unless files can be made in `folder` and in every folder below it, as on a read-only disk."""
    top = Path(folder)
    for place in (_nearest(top), *(path for path in top.rglob("*") if path.is_dir())):
        if not place.is_dir() or not os.access(place, os.W_OK | os.X_OK):
            raise _unfit(place, what)


def _nearest(folder: Path) -> Path:
    """The folder itself, or what is there of those above it."""
    return next(place for place in (folder, *folder.absolute().parents) if os.path.lexists(place))


def _unfit(place: Path, what: str) -> InputError:
    return InputError(f"{place} cannot be written; {what} need a folder in which files can be made")


# --- what is wrong ---------------------------------------------------------------------------------------------------


class Problem(NamedTuple):
    """A key, and what is wrong with its value."""

    path: KeyPath
    text: str

    def line(self, config: Mapping[str, Any], files: Sequence[str | Path]) -> str:
        """Return it with the file and line of the value."""
        return f"{origin(self.path, config, files)}: {dotted(self.path) or 'the config'} {self.text}"


NOUNS = {
    "number": "a number",
    "integer": "a whole number",
    "string": "text",
    "boolean": "true or false",
    "object": "a mapping of keys to values",
    "null": "null",
}
BOUNDS = {
    "exclusiveMinimum": "greater than",
    "minimum": "at least",
    "exclusiveMaximum": "less than",
    "maximum": "at most",
    "multipleOf": "a multiple of",
}
ITEMS = {"minItems": "at least", "maxItems": "at most"}
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?", re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+")


def problems(error: ValidationError, schema: Mapping[str, Any]) -> list[Problem]:
    """List what an error of a model says, in words that name value and what is allowed, by the model's JSON schema."""
    found: list[Problem] = []
    missing: list[KeyPath] = []
    meant: set[KeyPath] = set()  # keys that are there, but misspelt
    for each in error.errors(include_url=False):
        refusal = each.get("ctx", {}).get("error")
        path = tuple(part for part in each["loc"] if part != "[key]")
        if isinstance(refusal, Refusal):
            found.append(Problem((*path, *refusal.path), refusal.text))
        elif each["type"] == "missing":
            missing.append(path)
        elif each["type"] in ("extra_forbidden", "invalid_key") or "[key]" in each["loc"]:
            known = _keys(_schema_of(schema, path[:-1]))
            key = str(path[-1])
            near = [name for name in known if len(key) > 3 and name.startswith(key)][:1]  # "hinge", for one
            near = near or difflib.get_close_matches(key, known, n=1, cutoff=0.8)
            meant |= {(*path[:-1], name) for name in near}
            hint = f"did you mean {near[0]!r}?" if near else f"it must be one of {', '.join(known)}"
            if key == "height" and "slenderness" in known:
                hint = "state slenderness, the height over the thickness"
            if key == "overburden_mass":
                hint = "walls of a config bear a force; the commands take a mass, by --overburden-mass"
            if key.isdecimal():
                hint += "; if it is the rest of a number, its decimal sign must be a point"
            found.append(Problem(path, f"is not a key; {hint}"))
        else:
            found.append(_misfit(each, schema))
    found += [Problem(path, "is missing") for path in missing if path not in meant]
    return list(dict.fromkeys(found))


def _schema_of(schema: Mapping[str, Any], path: KeyPath) -> Mapping[str, Any]:
    """The part of a JSON schema that describes the value at a path; the last one on the way that there is."""
    part = _referred(schema, schema)
    for key in path:
        of_key = part.get("items") if isinstance(key, int) else part.get("properties", {}).get(key)
        of_key = of_key or part.get("additionalProperties")
        if not isinstance(of_key, Mapping):
            return part
        part = _referred(of_key, schema)
    return part


def _referred(part: Mapping[str, Any], schema: Mapping[str, Any]) -> Mapping[str, Any]:
    """A part of the schema with its reference followed, also that of a section that may be null."""
    options = part.get("anyOf", ())
    if len(options) == 2 and options[1] == {"type": "null"}:
        part = options[0]
    return schema["$defs"][part["$ref"].rpartition("/")[2]] if "$ref" in part else part


def _keys(schema: Mapping[str, Any]) -> list[str]:
    return list(schema.get("properties") or schema.get("propertyNames", {}).get("enum", ()))


def _misfit(error: ErrorDetails, schema: Mapping[str, Any]) -> Problem:
    path = error["loc"]
    # Pydantic names the options of a union as if they were keys below it.
    ends = [end for end in range(len(path)) if "anyOf" in _schema_of(schema, path[:end])]
    path = path[: ends[0]] if ends else path
    value, described = error["input"], _schema_of(schema, path)
    allowed = _allowed(described)
    if isinstance(value, list) and error["type"] in ("too_short", "too_long"):
        return Problem(path, f"has {len(value)} of them; it must be {allowed}")
    if error["type"] == "finite_number":
        return Problem(path, f"is {shown(value)}; it must be a finite number")
    if isinstance(value, str) and _DECIMAL_COMMA.fullmatch(value):
        return Problem(path, f"is the text {value!r}; it must be {allowed} (a number's decimal sign is a point)")
    if isinstance(value, str) and _NUMBER.fullmatch(value):
        return Problem(path, f"is the text {value!r}; it must be {allowed} (YAML's numbers have no quotes)")
    if isinstance(value, str) and (hint := _without_unit(value, described.get("description", ""))):
        return Problem(path, f"is the text {value!r}; it must be {allowed}{hint}")
    said = "a mapping of keys to values" if isinstance(value, Mapping) else shown(value)
    share = 1 in (described.get("maximum"), described.get("exclusiveMaximum")) and path[-1] != "step"
    slip = per_cent(value, lambda each: (each > 0) & (each <= 1)) if share and isinstance(value, (int, float)) else ""
    unit = re.search(r" \[(?!-\])[^\[\]]+\]$", described.get("description", ""))
    return Problem(path, f"is {said}; it must be {allowed}{unit[0] if unit else ''}{slip}")


def _without_unit(text: str, description: str) -> str:
    """Say which number stands in a config for one with a unit or in per cent; `description` ends in the key's unit."""
    unit = re.search(r"\[([^\[\]]+)\]$", description)
    try:
        return f", in {unit[1]} and without the unit: {units.quantity(text, unit[1]):.6g}" if unit else ""
    except units.UnitError:
        return units.as_fraction(text)


def _allowed(schema: Mapping[str, Any]) -> str:
    """Say in words what a part of the schema accepts."""
    if "anyOf" in schema:
        return " or ".join(_allowed(option) for option in schema["anyOf"])
    if "const" in schema:
        return repr(schema["const"])
    if "enum" in schema:
        return f"one of {', '.join(map(str, schema['enum']))}"
    kind = NOUNS.get(schema.get("type", "object"), "a list of" if ITEMS.keys() & schema.keys() else "a list")
    bounds = {word: schema[keyword] for keyword, word in (BOUNDS | ITEMS).items() if keyword in schema}
    return f"{kind} {' and '.join(f'{word} {bound:.15g}' for word, bound in bounds.items())}".strip()
