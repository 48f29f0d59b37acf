"""Beyond the paper, without earthquakes: the schemes' order, the amplitude, and measured trials of free rocking."""


rule convergence:
    output:
        "<results>/convergence.nc",
    log:
        "<logs>/convergence.log",
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
        "<results>/amplitude.nc",
    log:
        "<logs>/amplitude.log",
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
        "<results>/measured_rocking.nc",
    log:
        "<logs>/measured_rocking.log",
    priority: 1  # it takes long
    params:
        *settings("measured_rocking"),
        *code("laboratory.measured_rocking"),
        *texts("measured_rocking"),
        function="laboratory.measured_rocking.measured_rocking",
        dataset="measured_rocking",
    script:
        "../scripts/dataset.py"
