"""The page that shows everything, and the decays that its explorer looks up; `snakemake --report` is apart from it."""


report: "../report/workflow.rst"


DATASETS = [
    "mechanism",
    "loops",
    *(f"match/{study}" for study in STUDIES),
    "equivalence",
    "validation",
    "calibration",
    "windows",
    "orders",
    "accuracy",
    "dispersion",
    "pulses",
    "natural/walls",
    "natural/check",
    "comparison",
    "population",
    "explorer",
]


rule explorer:
    input:
        matches=f"{RESULTS}/match/amplitude.nc",
        code=code("rockdamp.studies.explorer_decays"),
    output:
        f"{RESULTS}/explorer.nc",
    log:
        f"{LOGS}/explorer.log",
    params:
        function="rockdamp.studies.explorer_decays.explorer",
        kind="explorer",
        version=version("rockdamp.studies.explorer_decays"),
        config=part("solver", "curve", "explorer"),
    message:
        "Decays for the report's explorer"
    script:
        "../scripts/dataset.py"


rule report:
    input:
        claims=rules.claims.output.claims,
        errata=rules.claims.output.errata,
        figures=[f"{RESULTS}/figures/{name}.png" for name in FIGURES],
        datasets=[f"{RESULTS}/{name}.nc" for name in DATASETS],
        assumptions="docs/assumptions.md",
        citation="CITATION.cff",
        code=code("rockdamp.report"),
    output:
        f"{RESULTS}/report.html",
    log:
        f"{LOGS}/report.log",
    params:
        figures=FIGURES,
        datasets=DATASETS,
        config=config,
        version=version("rockdamp.report"),
    message:
        "The report: claims, figures, explorer, accuracy and versions on one page"
    script:
        "../scripts/report.py"
