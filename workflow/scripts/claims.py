"""The verdicts on claims and, of the paper, the evidence for its errata: all tables, or none."""

from contextlib import ExitStack
from pathlib import Path

from boundary import job, open_datasets

with job(snakemake):
    from rockdamp import claims
    from rockdamp.claims import errata
    from rockdamp.storage.atomic import replacing

    results, kind = snakemake.config["results"], snakemake.params.kind
    names = [Path(path).relative_to(results).with_suffix("").as_posix() for path in snakemake.input.datasets]
    datasets = dict(zip(names, open_datasets(snakemake), strict=True))
    judges = claims.MEASURED if kind == "measured_claims" else claims.JUDGES
    verdicts = claims.judge(claims.read(snakemake.input.claims), datasets, judges)
    with ExitStack() as stack:
        table, structure, *others = (stack.enter_context(replacing(path)) for path in snakemake.output)
        claims.table(verdicts).to_csv(table, index=False, lineterminator="\n")
        structure.write_text(claims.as_json(verdicts), encoding="utf-8", newline="\n")
        for path in others:
            evidence = errata.table(errata.read(snakemake.input.errata), datasets)
            evidence.to_csv(path, index=False, lineterminator="\n")
