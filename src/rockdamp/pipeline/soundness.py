"""Which results a config has, what each must be made of, and which of those that are there are not."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

from rockdamp.pipeline.figures import FIGURES, REPORT_MODULES, Drawing
from rockdamp.pipeline.stages import STAGES, Stage
from rockdamp.progress import track
from rockdamp.storage import notes
from rockdamp.storage.provenance import code_version, config_digest, subset
from rockdamp.vocabulary import STUDIES

STATES = Path(".snakemake/states")  # seen from the folder of the run
LONG_AGO = 1_000_000_000  # time of a state that asks for nothing
FOR_ALL = "rockdamp.storage.dataset"  # by which each dataset is written and read

Config = Mapping[str, Any]
Count = Callable[[Sequence[str]], int]  # how many ground motions a list names
Signature = list[int]


class Result(NamedTuple):
    """What one job makes."""

    name: str  # as in `notes.place`
    files: tuple[str, ...]  # seen from the folder of the results
    code_version: str
    config_sha256: str
    kind: str = ""  # of a dataset


def tag(folder: str) -> str:
    """Return a name for what belongs to a folder of results: its own below ``results``, with a digest elsewhere."""
    relative = os.path.normpath(folder)
    if relative == "results":
        return relative
    if relative.startswith("results/"):
        return relative.removeprefix("results/")
    return f"{os.path.basename(relative)}-{config_digest({'results': os.path.abspath(folder)})[:8]}"


@cache
def version(*modules: str) -> str:
    """Return version and digest of the sources of `modules` and of what reads and writes datasets."""
    return code_version(*modules, FOR_ALL)


def modules_of(taker: Stage | Drawing) -> tuple[str, ...]:
    """Return the modules whose sources a stage or a figure depends on."""
    if isinstance(taker, Stage):
        return (taker.module,)
    return (f"rockdamp.figures.{taker.module}", "rockdamp.figures.output")


def stated(config: Config, key: str) -> Any:
    """Return the value of a dotted key of the config."""
    value: Any = config
    for name in key.split("."):
        value = value[name]
    return value


def shares(stage: Stage, config: Config, count: Count) -> list[int]:
    """Return the numbers of the shares that make up a stage's dataset, whose name has {share} in it."""
    whole = stated(config, stage.shares_of)
    total = whole if isinstance(whole, int) else count(whole)
    return list(range(-(-total // stated(config, stage.per_share))))


def results(config: Config, count: Count) -> Iterator[Result]:
    """Yield what the jobs of a config make, in the order of the tables."""
    for stage in STAGES.values():
        studies = list(STUDIES) if "{study}" in stage.file else [""]
        parts = shares(stage, config, count) if "{share}" in stage.file else [0]
        for study, share in product(studies, parts):
            keys = [key.format(study=study, share=share) for key in stage.config]
            yield _of_stage(stage, stage.file.format(study=study, share=share), subset(config, *keys))
    own = config_digest(subset(config, "figures"))
    for figure in FIGURES.values():
        files = tuple(f"figures/{figure.name}.{suffix}" for suffix in config["figures"]["formats"])
        yield Result(f"figures/{figure.name}", files, version(*modules_of(figure)), own)
    yield Result("report", ("report.html",), version(*REPORT_MODULES), config_digest(config))


def _of_stage(stage: Stage, file: str, part: Config) -> Result:
    name, suffix = os.path.splitext(file)
    if stage.name == "claims":
        return Result(name, (file, "errata.csv"), version("rockdamp.claims.errata"), config_digest(part))
    kind = stage.name if suffix == ".nc" else ""
    return Result(name, (file,), version(*modules_of(stage)), config_digest(part), kind)


# --- results that are there -------------------------------------------------------------------------------------------


def unsound(folder: str | os.PathLike[str], expected: Sequence[Result]) -> Iterator[tuple[str, str]]:
    """Yield each file of a folder of results that is not what its rule makes, or is of no rule, with the reason."""
    digests = _Digests({})
    for result in track(expected, "verify", len(expected)):
        reasons = _reasons(Path(folder), result, digests)
        yield from ((str(Path(folder, file)), reason) for file, reason in reasons.items())
    known = {os.path.join(".", file) for result in expected for file in (*result.files, "README.md")}
    for path in _files(Path(folder)):
        if notes.inside(folder, path) not in known:
            yield str(path), "is of no rule of this config"


def _files(folder: Path) -> Iterator[Path]:
    """The files below a folder, but hidden ones and the results of another config."""
    for path in sorted(folder.iterdir()) if folder.is_dir() else ():
        if path.name.startswith("."):
            continue
        if path.is_dir() and not path.is_symlink():
            if not (path / notes.FOLDER).is_dir():
                yield from _files(path)
        else:
            yield path


class _Digests(dict[str, str]):
    """Digests of files, each computed once; those whose signature is known are not computed again."""

    def __init__(self, known: Mapping[str, tuple[Signature, str]]) -> None:
        super().__init__()
        self.known = known

    def __missing__(self, path: str) -> str:
        signature, value = self.known.get(path, ([], ""))
        if not value or signature != signature_of(path):
            value = notes.digest(path)
        self[path] = value
        return value


def signature_of(path: str) -> Signature:
    """Return what tells that a file was not touched: the time of the last change, which no copying sets, and more."""
    try:
        found = os.stat(path)
    except OSError:
        return []
    return [found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns]


def _reasons(folder: Path, result: Result, digests: Mapping[str, str]) -> dict[str, str]:
    """The files of a result that are not what its rule makes, and why."""
    missing = {file: "is missing" for file in result.files if not os.path.lexists(folder / file)}
    there = [file for file in result.files if file not in missing]
    reason = _of_another(folder, result, digests) if there else ""
    if reason:
        return missing | dict.fromkeys(there, reason)
    written = notes.read(folder, result.name).get("files", {})
    changed = [file for file in there if digests[str(folder / file)] != written.get(f"./{file}", "none")]
    return missing | dict.fromkeys(changed, "is not what was written, by its digest")


def _of_another(folder: Path, result: Result, digests: Mapping[str, str]) -> str:
    """Why a result was not made by its rule in this tree, by its note; empty where it was."""
    note = notes.read(folder, result.name)
    if not note:
        return "has no note of what it was made of"
    if note["config_sha256"] != result.config_sha256:
        return "was made with another config"
    if note["code_version"] != result.code_version:
        return f"was made by other sources, {note['code_version']}; these are {result.code_version}"
    for name, value in note["inputs"].items():
        if digests[str(folder / name) if name.startswith("./") else name] != value:
            return f"was made of another {name.removeprefix('./')}"
    return ""


# --- what Snakemake is told -------------------------------------------------------------------------------------------


def expected_file(states: Path, config: Config) -> Path:
    """Return the file that says what each result of a config must state: another run may have another config."""
    return states / f"expected-{config_digest(config)[:16]}.json"


def tell(folder: str | os.PathLike[str], states: Path, config: Config, expected: Sequence[Result]) -> None:
    """Write a state for each result, which its rule has as an input, and what the jobs must find in their inputs.

    Snakemake builds what is older than an input. The state of a result that is what its rule makes is as old as can be;
    that of any other is new, so that it is built again even where nothing remembers how it was made.
    """
    known = _known(states / "digests.json")
    digests = _Digests(known)
    for result in expected:
        path, reasons = states / f"{result.name}.json", _reasons(Path(folder), result, digests)
        path.parent.mkdir(parents=True, exist_ok=True)
        moment = time.time_ns()
        if reasons or not path.exists():
            # Another text each time: Snakemake passes over an input that is newer but the same.
            path.write_text(json.dumps({"reasons": reasons, "moment": moment}), encoding="utf-8")
        latest = max(
            (signature[2] for file in result.files if (signature := signature_of(str(Path(folder, file))))), default=0
        )
        stamp = max(moment, latest + 10**9) if reasons else LONG_AGO * 10**9
        os.utime(path, ns=(stamp, stamp))
    _keep(expected_file(states, config), {f"./{file}": result for result in expected for file in result.files})
    _keep(
        states / "digests.json", {path: [signature_of(path), value] for path, value in sorted(digests.items()) if value}
    )


def expectations(state: str, config: Config) -> tuple[dict[str, Result], str]:
    """Return what a job must find in its inputs, by their names in notes, and the name of its own result."""
    states = Path(*Path(state).parts[: len(STATES.parts) + 1])
    table = json.loads(expected_file(states, config).read_text(encoding="utf-8"))
    return {name: Result(*entry) for name, entry in table.items()}, os.path.splitext(os.path.relpath(state, states))[0]


def _known(path: Path) -> dict[str, tuple[Signature, str]]:
    try:
        return {name: (signature, value) for name, (signature, value) in json.loads(path.read_text("utf-8")).items()}
    except (OSError, ValueError, AttributeError, TypeError):
        return {}


def _keep(path: Path, content: Any) -> None:
    text = json.dumps(content, indent=1)
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")
