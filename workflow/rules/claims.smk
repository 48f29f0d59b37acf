"""The paper's claims, judged from the datasets, and its errata: what is true."""


rule claims:
    input:
        datasets=built(STAGES["claims"].inputs),
        claims="data/claims.yaml",
        errata="data/errata.yaml",
        state=state("claims"),
        code=code("rockdamp.claims.errata"),
    output:
        claims=f"{RESULTS}/{STAGES['claims'].file}",
        errata=f"{RESULTS}/errata.csv",
    log:
        f"{LOGS}/claims.log",
    params:
        version=version("rockdamp.claims.errata"),
    message:
        said(STAGES["claims"])
    script:
        "../scripts/claims.py"
