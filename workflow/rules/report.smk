"""The report, and the page of the paper alone."""

# What the pages are made of, besides results.
TEMPLATES = expand(
    "src/rockdamp/report/{file}",
    file=["figures.yaml", "report.html.j2", "report.css", "page.js"],
)
BEYOND = "calibration measured_rocking convergence amplitude order loss_law supports earthquakes/walls".split()


rule report:
    input:
        TEMPLATES,
        claims="<results>/claims.csv",
        errata="data/errata.yaml",
        figures=expand("<results>/figures/{figure}.png", figure=FIGURES),
        datasets=[
            *rules.claims.input.datasets,
            *rules.earthquakes.input,
            *expand("<results>/{dataset}.nc", dataset=BEYOND),
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
