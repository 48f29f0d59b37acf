"""`verify` and `nrml`: check and pass on the built results."""

from __future__ import annotations

import math
from pathlib import Path

import click

from rockdamp.cli.assessment import modelling_option, write_nrml
from rockdamp.cli.command import Command, OutputFile, print_json
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


@click.command(cls=Command, examples=["rockdamp nrml results/population.nc population.xml"])
@click.argument("dataset", type=click.Path(path_type=Path), metavar="POPULATION.nc")
@click.argument("output", type=OutputFile(".xml"))
@modelling_option
def nrml(dataset: Path, output: Path, modelling_dispersion: float) -> None:
    """Fragility of the population, for OpenQuake.

    Write the fragility by PGV of the population of walls, which `snakemake population` builds, as NRML 0.5. For
    restitution and each damper there is a continuous function, and a discrete one at the intensities that were run. The
    dispersions are record to record, and of the walls; --modelling-dispersion adds another.
    `assess` and `batch` write the same for your walls with --nrml.
    """
    from rockdamp.assessment.answers import population_fragilities
    from rockdamp.errors import InputError
    from rockdamp.plausibility import warn
    from rockdamp.storage import dataset as storage

    population = storage.open(dataset)
    try:
        storage.check(population, "population")
    except storage.DatasetError as error:
        raise InputError(f"{dataset}: is no dataset of the population, as results/population.nc is ({error})") from None
    fragilities = population_fragilities(population)
    bare = [one.name for one in fragilities if math.isnan(one.median)]
    if bare:
        warn([f"{', '.join(bare)}: no continuous function, as the shares that collapse define none"])
    write_nrml(fragilities, "PGV", output, modelling_dispersion)
