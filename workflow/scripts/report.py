"""The report: every table, figure and dataset that it shows, read and handed to the package."""

import json
import os
from pathlib import Path

from boundary import job, open_datasets

with job(snakemake):
    from rockdamp.config import parse_config
    from rockdamp.report import Content, tables, write

    paths, params = snakemake.input, snakemake.params
    content = Content(
        claims=json.loads(Path(paths.verdicts).read_text(encoding="utf-8")),
        measured=[row for path in paths.measured for row in json.loads(Path(path).read_text(encoding="utf-8"))],
        errata=tables.rows(paths.errata),
        figures={name: Path(path).read_bytes() for name, path in zip(params.figures, paths.figures, strict=True)},
        datasets=dict(zip(params.datasets, open_datasets(snakemake), strict=True)),
        assumptions=Path(paths.assumptions).read_text(encoding="utf-8"),
        citation=Path(paths.citation).read_text(encoding="utf-8"),
        config=parse_config(snakemake.config),
        stated=snakemake.config if params.config else {},
        code_version=params.version,
        documents=Path(os.path.relpath(Path(paths.assumptions).parent, Path(snakemake.output[0]).parent)).as_posix(),
    )
    write(content, snakemake.output[0])
