"""A folder in which every result of the minimal config has a note, as if its rule had made it."""

from pathlib import Path

from repository import ROOT

from rockdamp.config.merging import merged
from rockdamp.motions import catalogue
from rockdamp.pipeline import soundness
from rockdamp.storage import notes

NEXT = {"coefficients": "equivalence", "claims": "equivalence", "report": "coefficients"}  # inputs that are made up


def minimal():
    """The results of the minimal config."""
    config = merged([ROOT / "config/default.yaml", ROOT / "config/minimal.yaml"], {})
    return list(soundness.results(config, lambda entries: len(catalogue.listing(entries))))


def make(folder, expected):
    """Write each file, with its name in it, and its note."""
    by_name = {result.name: result for result in expected}
    for result in expected:
        for file in result.files:
            Path(folder, file).parent.mkdir(parents=True, exist_ok=True)
            Path(folder, file).write_text(file, encoding="utf-8")
    for result in expected:
        inputs = [Path(folder, file) for file in by_name[NEXT[result.name]].files] if result.name in NEXT else []
        notes.write(
            folder,
            result.name,
            code_version=result.code_version,
            config_sha256=result.config_sha256,
            files=[Path(folder, file) for file in result.files],
            inputs={str(path): notes.digest(path) for path in inputs},
        )
