"""The page that shows everything; `snakemake --report` is apart from it."""


report: "../report/workflow.rst"


rule report:
    input:
        verdicts=rules.claims.output.verdicts,
        errata=rules.claims.output.errata,
        figures=[f"{RESULTS}/figures/{name}.png" for name in FIGURES],
        datasets=dataset_files(REPORTED),
        assumptions="docs/assumptions.md",
        citation="CITATION.cff",
    output:
        f"{RESULTS}/report.html",
    log:
        f"{LOGS}/report.log",
    params:
        figures=list(FIGURES),
        datasets=REPORTED,
        attributes=expected_attributes,
        config=CONFIG.plain(),
        sources=REPORT,
        version=REPORT.version(),
    message:
        "The report: claims, figures, explorer, accuracy and versions on one page"
    script:
        "../scripts/report.py"
