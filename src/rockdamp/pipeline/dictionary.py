"""Write the data dictionary of a folder of results, dictionary.md, from its datasets: it ends a build."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from rockdamp.pipeline.figures import FIGURES
from rockdamp.pipeline.stages import STAGES, reported, writes
from rockdamp.pipeline.verification import DICTIONARY
from rockdamp.storage import dataset, glossary
from rockdamp.storage.atomic import replacing
from rockdamp.vocabulary import STUDIES

GLOSSARY = "storage/glossary.yaml"  # of which all counts here: datasets that commands write are listed too


def used_by(kind: str) -> list[str]:
    """Return the stages, figures and pages that use a stage's dataset."""
    inputs: dict[str, Sequence[str]] = {name: stage.datasets for name, stage in STAGES.items()}
    inputs |= {name: figure.inputs for name, figure in FIGURES.items()}
    inputs["report"] = reported(STAGES.values())
    return [name for name, datasets in inputs.items() if any(writes(STAGES[kind], dataset) for dataset in datasets)]


def write(folder: str | os.PathLike[str]) -> None:
    """Write the data dictionary of a folder of results; of studies and chunks the first stands for all."""
    built = {name: Path(folder, stage.first_file) for name, stage in STAGES.items() if stage.dataset}
    with replacing(Path(folder, DICTIONARY)) as temporary:
        text = "\n".join(_lines({name: path for name, path in built.items() if path.is_file()}))
        temporary.write_text(f"{text}\n", encoding="utf-8", newline="\n")


def _lines(built: Mapping[str, Path]) -> Iterator[str]:
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
    return " | ".join(texts.get(key, "") for key in dataset.ATTRIBUTES)
