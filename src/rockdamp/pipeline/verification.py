"""What ends a build, its data dictionary and its checksums, and what verifies a build by these.

Each file must be of the config and the sources at hand, and have the bytes that were written.

Snakemake decides what runs. At the end of a complete build one list is written, checksums.csv in the folder of the
results, with the checksum, the config and the sources of each file. `mismatches` compares a folder with its list.
"""

from __future__ import annotations

import csv
import hashlib
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import NamedTuple

from rockdamp.config import Config
from rockdamp.pipeline.tables import FIGURES, REPORT, STAGES, built, drawn, reported, writes
from rockdamp.progress import track
from rockdamp.storage import glossary
from rockdamp.storage.atomic import replacing
from rockdamp.storage.provenance import Sources, config_digest
from rockdamp.vocabulary import STUDIES

CHECKSUMS = "checksums.csv"  # in the folder of the results
COLUMNS = ("file", "sha256", "config_sha256", "code_version")
DICTIONARY = "dictionary.md"
SOURCES = Sources((__name__,))  # of both
GLOSSARY = "storage/glossary.yaml"  # of which all counts here: datasets that commands write are listed too


class Origin(NamedTuple):
    """The digest of the part of the config and the version of the sources that a result is made by."""

    config_sha256: str
    code_version: str


def origins(config: Config, count: Callable[[Sequence[str]], int]) -> dict[str, Origin]:
    """Return the origin of each result of a config, by its file; `count` returns how many motions a list names."""
    expected: dict[str, Origin] = {}
    stages = built(config)
    for stage in stages.values():
        version = stage.sources.version()
        for study in STUDIES if "{study}" in stage.file else [""]:
            keys = [key.format(study=study) for key in stage.config]
            origin = Origin(config_digest(config.part(keys).plain()), version)
            for chunk, file in product(stage.chunks(config, count), (stage.file, *stage.also)):
                expected[file.format(study=study, chunk=chunk)] = origin
    drawn_with = config_digest(config.part(["figures"]).plain())
    for figure in drawn(reported(stages.values())).values():
        origin = Origin(drawn_with, figure.sources.version())
        expected |= {f"figures/{figure.name}.{suffix}": origin for suffix in config.figures.formats}
    expected[DICTIONARY] = Origin(config_digest({}), SOURCES.version())
    page = Origin(config_digest(config.plain()), REPORT.version())
    return expected | {"report.html": page, "paper.html": page}


def write_checksums(folder: str | os.PathLike[str], expected: Mapping[str, Origin]) -> None:
    """Write the list of a folder in which every result was just built or found up to date.

    A dataset that states another origin was put in the place of the result, and raises `DatasetError`.
    """
    from rockdamp.storage import dataset  # slow to load, and the Snakefile imports this module at every start

    for file, origin in expected.items():
        if file.endswith(".nc"):
            with dataset.connect(Path(folder, file)) as result:
                dataset.require_attributes(result, Path(folder, file), origin._asdict())
    with replacing(Path(folder, CHECKSUMS)) as temporary, open(temporary, "w", encoding="utf-8", newline="") as opened:
        rows = csv.writer(opened, lineterminator="\n")
        rows.writerow(COLUMNS)
        rows.writerows((name, _checksum(Path(folder, name)), *origin) for name, origin in expected.items())


def mismatches(folder: str | os.PathLike[str], expected: Mapping[str, Origin]) -> Iterator[tuple[str, str]]:
    """Yield each file of a folder of results that this config and these sources did not make, with the reason.

    Files that a result should have and that are missing are named too, and files that are no result. Hidden files and
    folders of results with a list of their own are passed over.
    """
    listed = _read_checksums(Path(folder))
    for file, origin in track(list(expected.items()), "verify", len(expected)):
        reason = _mismatch(Path(folder, file), origin, listed.get(file, {}))
        if reason:
            yield str(Path(folder, file)), reason
    for path in _files(Path(folder)):
        if path.relative_to(folder).as_posix() not in {*expected, CHECKSUMS, "README.md"}:
            yield str(path), "is not a result of this config"


def _mismatch(path: Path, origin: Origin, entry: Mapping[str, str]) -> str:
    if not os.path.lexists(path):
        return "is missing"
    if not entry:
        return f"is not in {CHECKSUMS}, the list of the last complete build"
    if entry["config_sha256"] != origin.config_sha256:
        return "was made with another config"
    if entry["code_version"] != origin.code_version:
        return f"was made by other sources, {entry['code_version']}; these are {origin.code_version}"
    if entry["sha256"] != _checksum(path):
        return "is not what the last complete build wrote, by its checksum"
    return ""


def _read_checksums(folder: Path) -> dict[str, dict[str, str]]:
    """Return the rows of a list by their files; none where there is no list, or it is damaged."""
    try:
        with open(folder / CHECKSUMS, encoding="utf-8", newline="") as file:
            return {row["file"]: row for row in csv.DictReader(file) if set(row) == set(COLUMNS)}
    except (OSError, UnicodeDecodeError, csv.Error, KeyError):
        return {}


def _checksum(path: Path) -> str:
    """Return the SHA-256 of a file; an empty text where it is no regular file, or cannot be read."""
    if not path.is_file():  # a named pipe would make us wait
        return ""
    try:
        with open(path, "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""


def _files(folder: Path) -> Iterator[Path]:
    for path in sorted(folder.iterdir()) if folder.is_dir() else ():
        if path.name.startswith("."):
            continue
        if not path.is_dir() or path.is_symlink():
            yield path
        elif not (path / CHECKSUMS).is_file():
            yield from _files(path)


# --- the data dictionary ----------------------------------------------------------------------------------------------


def used_by(kind: str) -> list[str]:
    """Return the stages, figures and pages that use a stage's dataset."""
    inputs: dict[str, Sequence[str]] = {name: stage.datasets for name, stage in STAGES.items()}
    inputs |= {name: figure.inputs for name, figure in FIGURES.items()}
    inputs["report"] = reported(STAGES.values())
    return [name for name, datasets in inputs.items() if any(writes(STAGES[kind], dataset) for dataset in datasets)]


def write_dictionary(folder: str | os.PathLike[str]) -> None:
    """Write the data dictionary of a folder of results; of studies and chunks the first stands for all."""
    built = {name: Path(folder, stage.first_file) for name, stage in STAGES.items() if stage.dataset}
    with replacing(Path(folder, DICTIONARY)) as temporary:
        text = "\n".join(_lines({name: path for name, path in built.items() if path.is_file()}))
        temporary.write_text(f"{text}\n", encoding="utf-8", newline="\n")


def _lines(built: Mapping[str, Path]) -> Iterator[str]:
    from rockdamp.storage import dataset  # slow to load, and the Snakefile imports this module at every start

    yield from (
        "# Data dictionary",
        "",
        f"Each file is NetCDF-4 under {dataset.CONVENTIONS} and opens with `xarray.open_dataset`. It has the",
        "attributes `title`, `source`, `references`, `Conventions`, `config_sha256` (digest of the part of the config",
        "that it depends on) and `code_version` (version and digest of the code that its values depend on). Of a file",
        "with `{study}`, the dimensions are those of the study of amplitude. Other studies have their own parameter:",
        f"{', '.join(f'`{parameter}` ({study})' for study, parameter in STUDIES.items())}.",
        f"Units and meanings are those of the package's `{GLOSSARY}`.",
    )
    for kind, path in built.items():
        yield from (
            "",
            f"## `{STAGES[kind].file}`",
            "",
            f"{STAGES[kind].title}. Used by {', '.join(used_by(kind))}.",
            "",
        )
        yield from ("| variable | dimensions | units | meaning | symbol |", "|---|---|---|---|---|")
        with dataset.connect(path) as opened:
            for name, variable in opened.variables.items():
                dims = ", ".join(f"`{dim}`" for dim in variable.dims) or "(none)"
                yield f"| `{name}` | {dims} | {_row(variable.attrs)} |"
    for kind, entry in glossary.read()["datasets"].items():
        if "written_by" in entry:
            yield from (
                "",
                f"## `{entry['file']}`",
                "",
                f"{entry['title']}. `{entry['written_by']}` writes such a file.",
            )
            yield from ("", "| variable | units | meaning | symbol |", "|---|---|---|---|")
            for name, texts in glossary.variables(kind).items():
                yield f"| `{name}` | {_row(texts)} |"


def _row(texts: Mapping[str, str]) -> str:
    from rockdamp.storage.dataset import ATTRIBUTES

    return " | ".join(texts.get(key, "") for key in ATTRIBUTES)
