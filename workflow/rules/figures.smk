"""A rule for each figure, from the table of figures: src/rockdamp/pipeline/figures.yaml."""

for figure in FIGURES.values():

    rule:
        name:
            figure.name
        input:
            datasets=dataset_files(figure.inputs),
        output:
            figure_files(figure),
        log:
            f"{LOGS}/figures/{figure.name}.log",
        params:
            function=figure.function,
            shows=figure.alternative,
            attributes=expected_attributes,
            sources=figure.sources,
            version=figure.sources.version(),
            config=config_part(["figures"]),
        message:
            figure.title
        script:
            "../scripts/figure.py"
