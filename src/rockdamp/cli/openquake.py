"""`nrml`: the fragility of the built population of walls, for OpenQuake."""

from __future__ import annotations

from pathlib import Path

import click

from rockdamp.cli.assessment import modelling_option, write_nrml
from rockdamp.cli.command import Command
from rockdamp.cli.types import OutputFile


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
    from rockdamp.storage import dataset as storage

    population = storage.open(dataset)
    try:
        storage.check(population, "population")
    except storage.DatasetError as error:
        raise InputError(f"{dataset}: is no dataset of the population, as results/population.nc is ({error})") from None
    write_nrml(population_fragilities(population), "PGV", output, modelling_dispersion)
