"""Check the folder of the results: it is theirs alone, and can be written. Check names of files."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterable
from pathlib import Path

from rockdamp.errors import InputError

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
