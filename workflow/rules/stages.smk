"""A rule for each dataset, from the table of stages: src/rockdamp/pipeline/stages.yaml."""


wildcard_constraints:
    study="|".join(STUDIES),
    chunk=r"\d+",


for stage in STAGES.values():
    if stage.dataset:

        rule:
            name:
                stage.rule
            input:
                unpack(inputs_of(stage)),
            output:
                f"{RESULTS}/{stage.file}",
            log:
                f"{LOGS}/{stage.dataset}.log",
            priority: stage.priority
            params:
                function=stage.function,
                kind=stage.name,
                records=list(stage.records),
                datasets=list(stage.inputs),
                attributes=expected_attributes,
                sources=stage.sources,
                version=stage.sources.version(),
                config_keys=stage.config,
                config=config_part(stage.config),
            message:
                message_of(stage)
            script:
                "../scripts/dataset.py"


rule coefficients:
    input:
        datasets=dataset_files(STAGES["coefficients"].datasets),
    output:
        f"{RESULTS}/{STAGES['coefficients'].file}",
    log:
        f"{LOGS}/coefficients.log",
    params:
        function=STAGES["coefficients"].function,
        attributes=expected_attributes,
        sources=STAGES["coefficients"].sources,
        version=STAGES["coefficients"].sources.version(),
    message:
        message_of(STAGES["coefficients"])
    script:
        "../scripts/table.py"


# Targets that stand for several files.
localrules:
    decay,
    match,
    equivalence,


rule decay:
    input:
        dataset_files(["decay/{study}"]),
    message:
        "The free decays of every study"


rule match:
    input:
        dataset_files(["match/{study}"]),
    message:
        "The matched damping ratios of every study"


rule equivalence:
    input:
        dataset_files(["equivalence"]),
        rules.coefficients.output,
    message:
        "The polynomials, as a dataset and as a table"


if {"earthquakes", "comparison"} <= STAGES.keys():

    rule earthquakes:
        input:
            dataset_files(["earthquakes", "earthquakes/check", "comparison"]),
        message:
            "The study of earthquakes"
