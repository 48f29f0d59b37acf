"""The verdicts on the paper's claims and the evidence for its errata, as CSV: both tables, or none."""

from pathlib import Path

from boundary import job

with job(snakemake) as given:
    from rockdamp import claims
    from rockdamp.claims import errata
    from rockdamp.storage.atomic import replacing

    results = Path(snakemake.output.claims).parent
    paths = snakemake.input.datasets
    names = [Path(path).relative_to(results).with_suffix("").as_posix() for path in paths]
    datasets = {name: given.open(path) for name, path in zip(names, paths, strict=True)}
    verdicts = claims.judge(claims.read(snakemake.input.claims), datasets)
    evidence = errata.table(errata.read(snakemake.input.errata), datasets)
    with replacing(snakemake.output.claims) as one, replacing(snakemake.output.errata) as other:
        verdicts.to_csv(one, index=False, lineterminator="\n")
        evidence.to_csv(other, index=False, lineterminator="\n")
