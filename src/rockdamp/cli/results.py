"""`datasets`: what is built."""

from __future__ import annotations

from pathlib import Path

import click

from rockdamp.cli.command import Command, print_json
from rockdamp.cli.options import json_option


@click.command(cls=Command, examples=["rockdamp datasets results"])
@click.argument("folder", type=click.Path(path_type=Path, exists=True, file_okay=False), default="results")
@json_option
def datasets(folder: Path, as_json: bool) -> None:
    """List what is built.

    For each dataset below FOLDER (by default results) its file, title, and dimensions with their sizes.
    """
    from rockdamp.storage.dataset import listing

    rows = listing(folder)
    if as_json:
        print_json(rows)
        return
    for row in rows:
        sizes = ", ".join(f"{dim} {size}" for dim, size in row["dimensions"].items())
        click.echo(f"{row['file']}\n    {row['title']}\n    {sizes or 'no dimensions'}")
