"""`verify`: check the built results."""

from __future__ import annotations

from pathlib import Path

import click

from rockdamp.cli.command import Command, print_json
from rockdamp.cli.options import json_option


@click.command(
    cls=Command,
    examples=["rockdamp verify results/minimal --configfile config/minimal.yaml"],
)
@click.argument("folder", type=click.Path(path_type=Path), required=False)
@click.option(
    "--configfile",
    "files",
    type=click.Path(path_type=Path),
    multiple=True,
    help="A config beside config/default.yaml, as Snakemake was given it; again for several.",
)
@json_option
def verify(folder: Path | None, files: tuple[Path, ...], as_json: bool) -> None:
    """List every result that this code and config did not make.

    A complete build writes checksums.csv into FOLDER, by default the config's. Each dataset, table, figure and the
    report is compared with its checksum, its config and the sources of the package. Run it in the folder of the
    project. The exit status is 1 if any result is missing or was made by another code or config.
    """
    from rockdamp.config.checks import validate
    from rockdamp.config.files import merged
    from rockdamp.laboratory.sections import LaboratoryConfig, broken
    from rockdamp.motions import catalogue
    from rockdamp.pipeline import verification

    merged_files = [Path("config/default.yaml"), *files]
    config = validate(LaboratoryConfig, merged(merged_files, {}), merged_files, [broken])
    expected = verification.origins(config, lambda entries: len(catalogue.listing(entries)))
    place = folder or Path(config.results)
    rows = [{"file": file, "reason": reason} for file, reason in verification.mismatches(place, expected)]
    if as_json:
        print_json(rows)
    else:
        for row in rows:
            click.echo(f"{row['file']} {row['reason']}")
        count = "1 of its files is" if len(rows) == 1 else f"{len(rows)} of its files are"
        verdict = f"{count} not of this tree" if rows else "all results are of this tree"
        click.echo(f"{place}: {verdict}", err=True)
    click.get_current_context().exit(1 if rows else 0)
