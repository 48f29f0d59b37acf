"""A rule for each dataset, from the table of stages: src/rockdamp/pipeline/stages.yaml."""


wildcard_constraints:
    study="|".join(STUDIES),
    share=r"\d+",


for stage in STAGES.values():
    if stage.dataset:

        rule:
            name:
                stage.rule
            input:
                record=[stated(stage.record)] if stage.record else [],
                ladder=stated(stage.ladder) if stage.ladder else [],
                datasets=built(stage.inputs, stage),
                watched=motions(stage),
                state=state(stage.dataset),
                code=code(*soundness.modules_of(stage)),
            output:
                f"{RESULTS}/{stage.file}",
            log:
                f"{LOGS}/{stage.dataset}.log",
            threads: stage.threads
            params:
                function=stage.function,
                kind=stage.name,
                lazy=stage.lazy,
                ladder=bool(stage.ladder),
                version=version(*soundness.modules_of(stage)),
                config=part(*stage.config),
            message:
                said(stage)
            script:
                "../scripts/dataset.py"


rule coefficients:
    input:
        datasets=built(STAGES["coefficients"].inputs),
        state=state("coefficients"),
        code=code(STAGES["coefficients"].module),
    output:
        f"{RESULTS}/{STAGES['coefficients'].file}",
    log:
        f"{LOGS}/coefficients.log",
    params:
        function=STAGES["coefficients"].function,
        version=version(STAGES["coefficients"].module),
    message:
        said(STAGES["coefficients"])
    script:
        "../scripts/table.py"


# Targets that stand for several files.
localrules:
    decay,
    match,
    equivalence,
    natural,


rule decay:
    input:
        built(["decay/{study}"]),
    message:
        "The free decays of every study"


rule match:
    input:
        built(["match/{study}"]),
    message:
        "The matched damping ratios of every study"


rule equivalence:
    input:
        built(["equivalence"]),
        rules.coefficients.output,
    message:
        "The polynomials, as a dataset and as a table"


rule natural:
    input:
        built(["natural", "natural/check", "comparison"]),
    message:
        "The study of earthquakes"
