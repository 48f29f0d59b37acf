"""A figure: a function of the package, called with the datasets that its rule lists."""

import importlib
import sys

from rockdamp.figures.style import save
from rockdamp.storage import dataset

sys.stderr = sys.stdout = open(snakemake.log[0], "w", encoding="utf-8", buffering=1)

module, _, name = snakemake.params.function.rpartition(".")
draw = getattr(importlib.import_module(f"rockdamp.{module}"), name)
figure = draw(*map(dataset.read, snakemake.input))
save(figure, snakemake.output, snakemake.params.resolution)
