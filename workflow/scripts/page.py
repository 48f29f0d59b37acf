"""The report, or the page of the paper alone: tables, figures and datasets that it shows, handed to the package."""

import os
import sys
from pathlib import Path

import yaml

from rockdamp.report.page import Content, write
from rockdamp.report.tables import read_rows
from rockdamp.storage import dataset

sys.stderr = sys.stdout = open(snakemake.log[0], "w", encoding="utf-8", buffering=1)

paths, output, results = snakemake.input, snakemake.output[0], snakemake.config["results"]
content = Content(
    claims=read_rows(paths.claims),
    errata=yaml.safe_load(Path(paths.errata).read_text(encoding="utf-8"))["errata"],
    figures={Path(path).stem: Path(path).read_bytes() for path in paths.figures},
    datasets={
        os.path.relpath(path, results).removesuffix(".nc"): dataset.read(path)
        for path in paths.datasets
    },
    yield_displacement_ratio=snakemake.params[0]["curve.yield_displacement_ratio"],
    documents=Path(os.path.relpath("docs", Path(output).parent)).as_posix(),
)
write(content, output)
