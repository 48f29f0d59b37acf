"""The paper's claims, judged from the datasets, and its errata: what is true."""


rule claims:
    input:
        datasets=dataset_files(STAGES["claims"].datasets),
        claims="data/claims.yaml",
        errata="data/errata.yaml",
    output:
        claims=f"{RESULTS}/claims.csv",
        verdicts=f"{RESULTS}/claims.json",
        errata=f"{RESULTS}/errata.csv",
    log:
        f"{LOGS}/claims.log",
    params:
        attributes=expected_attributes,
        sources=STAGES["claims"].sources,
        version=STAGES["claims"].sources.version(),
    message:
        message_of(STAGES["claims"])
    script:
        "../scripts/claims.py"
