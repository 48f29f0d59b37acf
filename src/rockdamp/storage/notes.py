"""Notes beside results: what each was made of, by which sources and config, with digests of it all.

A note is a hidden file in the folder of the results, one for each job. A result without a note, or that differs from
what its note says, is not known to be what its rule makes, whatever Snakemake remembers of it.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from rockdamp.storage.atomic import replacing

FOLDER = ".provenance"  # in that of the results


def place(results: str | os.PathLike[str], name: str) -> Path:
    """Return where the note of a job lies, which is named as its result without suffix: ``match/amplitude``."""
    return Path(results, FOLDER, f"{name}.json")


def digest(path: str | os.PathLike[str]) -> str:
    """Return the SHA-256 of a file, or an empty text where none can be read."""
    try:
        if not Path(path).is_file():
            return ""
        with open(path, "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""


def write(
    results: str | os.PathLike[str],
    name: str,
    *,
    code_version: str,
    config_sha256: str,
    files: Iterable[str],
    inputs: Mapping[str, str],
) -> None:
    """Write the note of a job that has ended.

    Parameters
    ----------
    results : path
    name : str
        As in `place`.
    code_version, config_sha256 : str
        Of `provenance`.
    files : iterable of str
        That the job wrote.
    inputs : dict of str
        Digest of each file that it read.

    Files in the folder of the results are named as seen from there, so that the folder may be moved.
    """
    note = {
        "code_version": code_version,
        "config_sha256": config_sha256,
        "files": {inside(results, path): digest(path) for path in files},
        "inputs": {inside(results, path): value for path, value in inputs.items()},
    }
    path = place(results, name)
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(note, indent=1, sort_keys=True) + "\n", encoding="utf-8", newline="\n")


def inside(results: str | os.PathLike[str], path: str | os.PathLike[str]) -> str:
    """Return how a note names a file: a result as seen from the folder of the results, after ``./``."""
    relative = os.path.relpath(path, results)
    return os.fspath(path) if relative.startswith("..") else f"./{Path(relative).as_posix()}"


def read(results: str | os.PathLike[str], name: str) -> dict[str, Any]:
    """Return a note; an empty one where there is none, or it is damaged."""
    try:
        note = json.loads(place(results, name).read_text(encoding="utf-8"))
        strings = [note["code_version"], note["config_sha256"], *note["files"].values(), *note["inputs"].values()]
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        return {}
    return note if all(isinstance(text, str) for text in strings) else {}
