"""Beyond the paper, without earthquakes: orders of the schemes, amplitude, measured rocking."""


rule convergence:
    output:
        "<results>/convergence.nc",
    log:
        "<logs>/convergence.log",
    params:
        *stage("studies.convergence.convergence", "convergence"),
    script:
        "../scripts/dataset.py"


rule amplitude:
    output:
        "<results>/amplitude.nc",
    log:
        "<logs>/amplitude.log",
    params:
        *stage("studies.amplitude.amplitude", "solver", "curve", "matching", "amplitude"),
    script:
        "../scripts/dataset.py"


rule measured_rocking:
    input:
        trials_file=project_file(CONFIG.measured_rocking.trials),
    output:
        "<results>/measured_rocking.nc",
    log:
        "<logs>/measured_rocking.log",
    priority: 1  # it takes long
    params:
        *stage("laboratory.stages.measured_rocking", "measured_rocking"),
        *files(project_file(CONFIG.measured_rocking.trials)),
    script:
        "../scripts/dataset.py"
