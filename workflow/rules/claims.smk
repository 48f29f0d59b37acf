"""The paper's claims, judged from the datasets, and its errata: what is true."""


rule claims:
    input:
        datasets=dataset_files(STAGES["claims"].inputs),
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
        code=source_files(STAGES["claims"].modules),
        version=code_version(*STAGES["claims"].modules),
    message:
        message_of(STAGES["claims"])
    script:
        "../scripts/claims.py"
