"""A rule for each figure, by its name in the table of rockdamp.figures."""

for figure, (module, datasets) in FIGURES.items():

    rule:
        name:
            figure
        input:
            expand("<results>/{dataset}.nc", dataset=datasets),
        output:
            report(f"<results>/figures/{figure}.png", category="Figures", labels={"figure": figure}),
            f"<results>/figures/{figure}.pdf",
        log:
            f"<logs>/figures/{figure}.log",
        params:
            *code(module, script="figure"),
            *package_files("figures/paper.mplstyle"),
            function=f"{module}.{figure}",
            resolution=CONFIG.figures.resolution,
        script:
            "../scripts/figure.py"


FIGURE_FILES = expand("<results>/figures/{figure}.{suffix}", figure=FIGURES, suffix=["png", "pdf"])
PAPER_FIGURES = [figure for figure in FIGURES if not figure.startswith("fig_")]
PAPER_FIGURE_FILES = [file for file in FIGURE_FILES if Path(file).stem in PAPER_FIGURES]
