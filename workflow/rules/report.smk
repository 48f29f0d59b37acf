"""The page that shows everything; `snakemake --report` is apart from it."""


report: "../report/workflow.rst"


rule report:
    input:
        claims=rules.claims.output.claims,
        errata=rules.claims.output.errata,
        figures=[f"{RESULTS}/figures/{name}.png" for name in FIGURES],
        datasets=built(reported()),
        assumptions="docs/assumptions.md",
        citation="CITATION.cff",
        state=state("report"),
        code=code(*REPORT_MODULES),
    output:
        f"{RESULTS}/report.html",
    log:
        f"{LOGS}/report.log",
    params:
        figures=list(FIGURES),
        datasets=reported(),
        config=config,
        version=version(*REPORT_MODULES),
    message:
        "The report: claims, figures, explorer, accuracy and versions on one page"
    script:
        "../scripts/report.py"
