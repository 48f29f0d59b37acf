"""The paper's claims, judged from the datasets, and its errata: what is true."""


rule claims:
    input:
        rules.mechanism.output,
        rules.loops.output,
        rules.match.input,
        rules.windows.output,
        rules.equivalence_fit.output,
        rules.validation.output,
        claims="data/claims.yaml",
        errata="data/errata.yaml",
        code=code("rockdamp.claims.errata"),
    output:
        claims=f"{RESULTS}/claims.csv",
        errata=f"{RESULTS}/errata.csv",
    log:
        f"{LOGS}/claims.log",
    params:
        version=version("rockdamp.claims.errata"),
    message:
        "A verdict on each of the paper's claims, and evidence for its errata"
    script:
        "../scripts/claims.py"
