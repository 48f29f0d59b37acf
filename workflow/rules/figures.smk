"""A rule for each figure, from the table of figures: src/rockdamp/pipeline/figures.yaml."""

for figure in FIGURES.values():

    rule:
        name:
            figure.name
        input:
            datasets=built(figure.inputs),
            code=code(f"rockdamp.figures.{figure.module}", "rockdamp.figures.output"),
        output:
            drawn(figure),
        log:
            f"{LOGS}/figures/{figure.name}.log",
        params:
            function=figure.function,
            shows=figure.alternative,
            version=version(f"rockdamp.figures.{figure.module}", "rockdamp.figures.output"),
            config=part("figures"),
        message:
            figure.title
        script:
            "../scripts/figure.py"
