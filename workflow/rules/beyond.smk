"""Beyond the paper, without earthquakes: the schemes' order, the amplitude, and measured trials of free rocking."""


rule convergence:
    output:
        RESULTS + "/convergence.nc",
    log:
        LOGS + "/convergence.log",
    params:
        *settings("convergence"),
        *code("studies.convergence"),
        *texts("convergence"),
        function="studies.convergence.convergence",
        dataset="convergence",
    script:
        "../scripts/dataset.py"


rule amplitude:
    output:
        RESULTS + "/amplitude.nc",
    log:
        LOGS + "/amplitude.log",
    params:
        *settings("solver", "curve", "matching", "amplitude"),
        *code("studies.amplitude"),
        *texts("amplitude"),
        function="studies.amplitude.amplitude",
        dataset="amplitude",
    script:
        "../scripts/dataset.py"


rule measured_rocking:
    input:
        CONFIG.measured_rocking.trials,
    output:
        RESULTS + "/measured_rocking.nc",
    log:
        LOGS + "/measured_rocking.log",
    priority: 1  # it takes long
    params:
        *settings("measured_rocking"),
        *code("laboratory.measured_rocking"),
        *texts("measured_rocking"),
        function="laboratory.measured_rocking.measured_rocking",
        dataset="measured_rocking",
    script:
        "../scripts/dataset.py"


rule measured_claims:
    input:
        claims="data/measured_claims.yaml",
        datasets=[RESULTS + "/measured_rocking.nc"],
    output:
        table=RESULTS + "/measured_claims.csv",
        structure=RESULTS + "/measured_claims.json",
    log:
        LOGS + "/measured_claims.log",
    params:
        *code("claims", script="claims"),
        judges="MEASURED",
    script:
        "../scripts/claims.py"
