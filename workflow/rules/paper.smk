"""The paper: force-displacement curves, decays, matched damping ratios, polynomials, a test, and its claims."""

SOLVER = settings("solver", "curve", "release_amplitude")
CLAIMED = [
    "mechanism",
    "damping_force",
    "response_lengths",
    "equivalence",
    "validation",
    "bilinear",
]


rule mechanism:
    output:
        "<results>/mechanism.nc",
    log:
        "<logs>/mechanism.log",
    params:
        *settings("wall", "curve", "validation.wall"),
        *code("studies.mechanism"),
        *texts("mechanism"),
        function="studies.mechanism.mechanism",
        dataset="mechanism",
    script:
        "../scripts/dataset.py"


rule decay_study:
    output:
        "<results>/decay/{study}.nc",
    log:
        "<logs>/decay/{study}.log",
    params:
        *SOLVER,
        *settings("wall", "restitution", "matching.response_length", "response_lengths.stop"),
        study_values,
        softer_plateau,
        *code("studies.decays"),
        *texts("decay"),
        function="studies.decays.study",
        dataset="decay",
    script:
        "../scripts/dataset.py"


rule decay:
    input:
        expand("<results>/decay/{study}.nc", study=STUDIES),


rule match_study:
    input:
        decays="<results>/decay/{study}.nc",
    output:
        "<results>/match/{study}.nc",
    log:
        "<logs>/match/{study}.log",
    params:
        *SOLVER,
        *settings("wall", "matching"),
        study_values,
        softer_plateau,
        *code("studies.matches"),
        *texts("match"),
        function="studies.matches.match",
        dataset="match",
    script:
        "../scripts/dataset.py"


rule match:
    input:
        MATCHES,


rule response_lengths:
    input:
        decays="<results>/decay/amplitude.nc",
    output:
        "<results>/response_lengths.nc",
    log:
        "<logs>/response_lengths.log",
    params:
        *SOLVER,
        *settings("wall", "studies.amplitude", "response_lengths"),
        *code("studies.response_lengths"),
        *texts("response_lengths"),
        function="studies.response_lengths.response_lengths",
        dataset="response_lengths",
    script:
        "../scripts/dataset.py"


rule damping_force:
    output:
        "<results>/damping_force.nc",
    log:
        "<logs>/damping_force.log",
    params:
        *SOLVER,
        *settings("matching", "damping_force"),
        *code("studies.damping_force"),
        *texts("damping_force"),
        function="studies.damping_force.damping_force",
        dataset="damping_force",
    script:
        "../scripts/dataset.py"


rule equivalence:
    input:
        matched="<results>/match/cracked_stiffness.nc",
    output:
        "<results>/equivalence.nc",
    log:
        "<logs>/equivalence.log",
    params:
        *settings("curve", "release_amplitude"),
        *code("studies.polynomial_fits"),
        *texts("equivalence"),
        function="studies.polynomial_fits.fit",
        dataset="equivalence",
    script:
        "../scripts/dataset.py"


rule coefficients:
    input:
        equivalence="<results>/equivalence.nc",
    output:
        "<results>/coefficients.csv",
    log:
        "<logs>/coefficients.log",
    params:
        *code("studies.polynomial_fits"),
        function="studies.polynomial_fits.table",
    script:
        "../scripts/dataset.py"


rule calibration:
    input:
        record=CONFIG.validation.record,
    output:
        "<results>/calibration.nc",
    log:
        "<logs>/calibration.log",
    params:
        *settings("validation.wall", "validation.curve", "validation.step"),
        *code("laboratory.calibration"),
        *texts("calibration"),
        function="laboratory.calibration.study",
        dataset="calibration",
    script:
        "../scripts/dataset.py"


rule validation:
    input:
        record=CONFIG.validation.record,
        equivalence="<results>/equivalence.nc",
        calibration="<results>/calibration.nc",
    output:
        "<results>/validation.nc",
    log:
        "<logs>/validation.log",
    params:
        *settings(
            "validation.wall",
            "validation.curve",
            "validation.step",
            "validation.fit_yield_displacement_ratios",
        ),
        *code("studies.validation"),
        *texts("validation"),
        function="studies.validation.validate",
        dataset="validation",
    script:
        "../scripts/dataset.py"


rule bilinear:
    input:
        record_files(CONFIG.bilinear.records),
    output:
        "<results>/bilinear.nc",
    log:
        "<logs>/bilinear.log",
    params:
        *settings("wall", "curve", "damping_force", "bilinear"),
        *code("studies.bilinear"),
        *texts("bilinear"),
        function="studies.bilinear.bilinear",
        dataset="bilinear",
    script:
        "../scripts/dataset.py"


rule claims:
    input:
        claims="data/claims.yaml",
        datasets=[*MATCHES, *expand("<results>/{dataset}.nc", dataset=CLAIMED)],
    output:
        "<results>/claims.csv",
    log:
        "<logs>/claims.log",
    params:
        *code("claims", script="claims"),
    script:
        "../scripts/claims.py"
