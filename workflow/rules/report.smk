"""The report, and the page of the paper alone."""

# What the pages are made of, besides results.
TEMPLATES = expand(
    "src/rockdamp/report/{file}",
    file=["figures.yaml", "report.html.j2", "report.css", "page.js"],
)


rule report:
    input:
        TEMPLATES,
        claims="<results>/claims.csv",
        errata="data/errata.yaml",
        figures=expand("<results>/figures/{figure}.png", figure=FIGURES),
        datasets=[
            *rules.claims.input.datasets,
            *rules.earthquakes.input,
            "<results>/calibration.nc",
            "<results>/measured_rocking.nc",
            "<results>/convergence.nc",
            "<results>/amplitude.nc",
            "<results>/earthquakes/walls.nc",
            "<results>/order.nc",
            "<results>/loss_law.nc",
            "<results>/supports.nc",
        ],
    output:
        "<results>/report.html",
    log:
        "<logs>/report.log",
    params:
        *settings("curve.yield_displacement_ratio"),
        *code("report.page", script="page"),
    script:
        "../scripts/page.py"


rule paper_page:
    input:
        TEMPLATES,
        claims="<results>/claims.csv",
        errata="data/errata.yaml",
        figures=expand("<results>/figures/{figure}.png", figure=PAPER_FIGURES),
        datasets=rules.claims.input.datasets,
    output:
        "<results>/paper.html",
    log:
        "<logs>/paper.log",
    params:
        *settings("curve.yield_displacement_ratio"),
        *code("report.page", script="page"),
    script:
        "../scripts/page.py"
