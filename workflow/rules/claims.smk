"""The paper's claims, judged from the datasets, and its errata; what measured trials say, apart from these."""

for stage in STAGES.values():
    if stage.name.endswith("claims"):

        rule:
            name:
                stage.rule
            input:
                datasets=dataset_files(stage.datasets),
                claims="data/measured_claims.yaml" if stage.name == "measured_claims" else "data/claims.yaml",
                errata="data/errata.yaml",
            output:
                [f"{RESULTS}/{file}" for file in (stage.file, *stage.also)],
            log:
                f"{LOGS}/{stage.name}.log",
            params:
                kind=stage.name,
                attributes=expected_attributes,
                sources=stage.sources,
                version=stage.sources.version(),
            message:
                stage.title
            script:
                "../scripts/claims.py"
