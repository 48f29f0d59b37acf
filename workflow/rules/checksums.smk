"""The list of all results with their checksums, which ends a build: `rockdamp verify` compares results with it."""


rule checksums:
    input:
        results=[f"{RESULTS}/{file}" for file in ORIGINS],
    output:
        f"{RESULTS}/{verification.CHECKSUMS}",
    log:
        f"{LOGS}/checksums.log",
    params:
        expected=ORIGINS,
        sources=verification.SOURCES,
        version=verification.SOURCES.version(),
    message:
        "The checksums of all results"
    script:
        "../scripts/checksums.py"
