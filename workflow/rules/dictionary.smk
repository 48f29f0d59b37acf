"""The data dictionary: what each dataset of a build holds."""


rule dictionary:
    input:
        dataset_files([stage.dataset for stage in STAGES.values() if stage.dataset]),
    output:
        f"{RESULTS}/{verification.DICTIONARY}",
    log:
        f"{LOGS}/dictionary.log",
    params:
        sources=verification.SOURCES,
        version=verification.SOURCES.version(),
    message:
        "The data dictionary of all datasets"
    script:
        "../scripts/dictionary.py"
