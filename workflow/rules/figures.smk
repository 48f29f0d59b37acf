"""A rule for each figure, from the table of figures: src/rockdamp/pipeline/figures.yaml."""

for figure in FIGURES.values():

    rule:
        name:
            figure.name
        input:
            datasets=built(figure.inputs),
            state=state(f"figures/{figure.name}"),
            code=code(*soundness.modules_of(figure)),
        output:
            drawn(figure),
        log:
            f"{LOGS}/figures/{figure.name}.log",
        params:
            function=figure.function,
            shows=figure.alternative,
            version=version(*soundness.modules_of(figure)),
            config=part("figures"),
        message:
            figure.title
        script:
            "../scripts/figure.py"
