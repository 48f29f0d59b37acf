"""The report, and the page of the paper alone."""

# What the pages are made of, besides results.
TEMPLATES = expand(
    "src/rockdamp/report/{file}",
    file=["figures.yaml", "report.html.j2", "earthquakes.html.j2", "report.css", "page.js"],
)


rule report:
    input:
        TEMPLATES,
        assumptions="docs/assumptions.md",
        citation="CITATION.cff",
        claims=RESULTS + "/claims.json",
        measured=RESULTS + "/measured_claims.json",
        errata=RESULTS + "/errata.csv",
        figures=expand(RESULTS + "/figures/{figure}.png", figure=FIGURES),
        datasets=[
            *rules.claims.input.datasets,
            *rules.earthquakes.input,
            RESULTS + "/calibration.nc",
            RESULTS + "/measured_rocking.nc",
            RESULTS + "/convergence.nc",
            RESULTS + "/amplitude.nc",
            RESULTS + "/earthquakes/walls.nc",
            RESULTS + "/order.nc",
            RESULTS + "/loss_law.nc",
            RESULTS + "/supports.nc",
        ],
    output:
        RESULTS + "/report.html",
    log:
        LOGS + "/report.log",
    params:
        *settings("curve.yield_displacement_ratio"),
        *code("report.page", script="page"),
    script:
        "../scripts/page.py"


rule paper_page:
    input:
        TEMPLATES,
        assumptions="docs/assumptions.md",
        citation="CITATION.cff",
        claims=RESULTS + "/claims.json",
        errata=RESULTS + "/errata.csv",
        figures=expand(RESULTS + "/figures/{figure}.png", figure=PAPER_FIGURES),
        datasets=rules.claims.input.datasets,
    output:
        RESULTS + "/paper.html",
    log:
        LOGS + "/paper.log",
    params:
        *settings("curve.yield_displacement_ratio"),
        *code("report.page", script="page"),
    script:
        "../scripts/page.py"
