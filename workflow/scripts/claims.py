"""The verdicts on the paper's claims and the evidence for its errata: all tables, or none."""

from pathlib import Path

from boundary import job, open_datasets

with job(snakemake):
    from rockdamp import claims
    from rockdamp.claims import errata
    from rockdamp.storage.atomic import replacing

    results = snakemake.config["results"]
    names = [Path(path).relative_to(results).with_suffix("").as_posix() for path in snakemake.input.datasets]
    datasets = dict(zip(names, open_datasets(snakemake), strict=True))
    verdicts = claims.judge(claims.read(snakemake.input.claims), datasets)
    evidence = errata.table(errata.read(snakemake.input.errata), datasets)
    paths = snakemake.output
    with replacing(paths.claims) as table, replacing(paths.verdicts) as structure, replacing(paths.errata) as other:
        claims.table(verdicts).to_csv(table, index=False, lineterminator="\n")
        structure.write_text(claims.as_json(verdicts), encoding="utf-8", newline="\n")
        evidence.to_csv(other, index=False, lineterminator="\n")
