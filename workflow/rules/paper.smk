"""The paper: curves, decays, matched damping ratios, polynomials, a test, and claims."""

DECAY = ("solver", "curve", "release_amplitude", "wall")
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
        *stage("studies.mechanism.mechanism", "wall", "curve", "validation.wall"),
    script:
        "../scripts/dataset.py"


rule decay_study:
    output:
        "<results>/decay/{study}.nc",
    log:
        "<logs>/decay/{study}.log",
    params:
        *stage(
            "studies.decays.decay",
            *DECAY,
            "restitution",
            "matching.response_length",
            "response_lengths.stop",
            dataset="decay",
        ),
        study_values,
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
        *stage("studies.matches.match", *DECAY, "matching"),
        study_values,
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
        *stage(
            "studies.response_lengths.response_lengths",
            *DECAY,
            "studies.amplitude",
            "response_lengths",
        ),
    script:
        "../scripts/dataset.py"


rule damping_force:
    output:
        "<results>/damping_force.nc",
    log:
        "<logs>/damping_force.log",
    params:
        *stage(
            "studies.damping_force.damping_force",
            "solver",
            "curve",
            "release_amplitude",
            "matching",
            "damping_force",
        ),
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
        *stage("studies.polynomial_fits.fit", "curve", "release_amplitude", dataset="equivalence"),
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
        {"function": "studies.polynomial_fits.table"},
        *code("studies.polynomial_fits"),
    script:
        "../scripts/dataset.py"


rule calibration:
    input:
        record=project_file(CONFIG.validation.record),
    output:
        "<results>/calibration.nc",
    log:
        "<logs>/calibration.log",
    params:
        *stage(
            "laboratory.stages.calibration",
            "validation.wall",
            "validation.curve",
            "validation.step",
        ),
        *files(project_file(CONFIG.validation.record)),
    script:
        "../scripts/dataset.py"


rule validation:
    input:
        record=project_file(CONFIG.validation.record),
        equivalence="<results>/equivalence.nc",
        calibration="<results>/calibration.nc",
    output:
        "<results>/validation.nc",
    log:
        "<logs>/validation.log",
    params:
        *stage(
            "studies.validation.validate",
            "validation.wall",
            "validation.curve",
            "validation.step",
            "validation.fit_yield_displacement_ratios",
            dataset="validation",
        ),
        *files(project_file(CONFIG.validation.record)),
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
        *stage("studies.bilinear.bilinear", "wall", "curve", "damping_force", "bilinear"),
        *motions(BILINEAR_RECORDS),
    script:
        "../scripts/dataset.py"


rule claims:
    input:
        claims=project_file("data/claims.yaml"),
        datasets=[*MATCHES, *expand("<results>/{dataset}.nc", dataset=CLAIMED)],
    output:
        "<results>/claims.csv",
    log:
        "<logs>/claims.log",
    params:
        *code("claims", script="claims"),
        *files(project_file("data/claims.yaml")),
    script:
        "../scripts/claims.py"
