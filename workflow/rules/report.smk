"""The report, and the page of the paper alone."""

PAGE = [
    *code("report.page", script="page"),
    *package_files(
        "report/figures.yaml", "report/report.html.j2", "report/report.css", "report/page.js"
    ),
    *files(project_file("data/errata.yaml")),
]
BEYOND = [
    "calibration",
    "measured_rocking",
    "convergence",
    "amplitude",
    "order",
    "loss_law",
    "supports",
    "earthquakes/walls",
]


rule report:
    input:
        claims="<results>/claims.csv",
        errata=project_file("data/errata.yaml"),
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
        *PAGE,
        yield_displacement_ratio=CONFIG.curve.yield_displacement_ratio,
    script:
        "../scripts/page.py"


rule paper_page:
    input:
        claims="<results>/claims.csv",
        errata=project_file("data/errata.yaml"),
        figures=expand("<results>/figures/{figure}.png", figure=PAPER_FIGURES),
        datasets=rules.claims.input.datasets,
    output:
        "<results>/paper.html",
    log:
        "<logs>/paper.log",
    params:
        *PAGE,
        yield_displacement_ratio=CONFIG.curve.yield_displacement_ratio,
    script:
        "../scripts/page.py"
