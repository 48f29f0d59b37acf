"""The report: every table, figure and dataset that it shows, read and handed to the package."""

from pathlib import Path

from boundary import job

with job(snakemake) as inputs:
    from rockdamp.report import Content, tables, write

    given, params = snakemake.input, snakemake.params
    content = Content(
        claims=tables.rows(given.claims, tables.CLAIMS),
        errata=tables.rows(given.errata, tables.ERRATA),
        figures={name: Path(path).read_bytes() for name, path in zip(params.figures, given.figures, strict=True)},
        datasets={name: inputs.open(path) for name, path in zip(params.datasets, given.datasets, strict=True)},
        assumptions=Path(given.assumptions).read_text(encoding="utf-8"),
        citation=Path(given.citation).read_text(encoding="utf-8"),
        config=params.config,
        code_version=params.version,
    )
    write(content, snakemake.output[0])
