"""The report, or the page of the paper alone, from tables, figures and datasets."""

import os
import sys
from pathlib import Path

import yaml

from rockdamp.report.page import Content, write
from rockdamp.report.tables import read_rows
from rockdamp.storage import dataset

sys.stderr = sys.stdout = open(snakemake.log[0], "w", encoding="utf-8", buffering=1)

output = snakemake.output[0]
datasets = {}
for path in snakemake.input.datasets:
    name = os.path.relpath(path, snakemake.config["results"]).removesuffix(".nc")
    datasets[name] = dataset.read(path)
errata = yaml.safe_load(Path(snakemake.input.errata).read_text(encoding="utf-8"))
content = Content(
    claims=read_rows(snakemake.input.claims),
    errata=errata["errata"],
    figures={Path(path).stem: Path(path).read_bytes() for path in snakemake.input.figures},
    datasets=datasets,
    yield_displacement_ratio=snakemake.params.yield_displacement_ratio,
    documents=Path(os.path.relpath("docs", Path(output).parent)).as_posix(),
    folder=snakemake.config["results"],
)
write(content, output)
