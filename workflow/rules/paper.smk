"""The paper: force-displacement curves, decays, matched damping ratios, polynomials, a test, and its claims."""

SOLVER = settings("solver", "curve", "release_amplitude")


rule mechanism:
    output:
        RESULTS + "/mechanism.nc",
    log:
        LOGS + "/mechanism.log",
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
        RESULTS + "/decay/{study}.nc",
    log:
        LOGS + "/decay/{study}.log",
    params:
        *SOLVER,
        *settings("wall", "restitution", "matching.response_length", "response_lengths.stop"),
        *STUDY_SETTINGS,
        *code("studies.decays"),
        *texts("decay"),
        function="studies.decays.study",
        dataset="decay",
    script:
        "../scripts/dataset.py"


rule decay:
    input:
        expand(RESULTS + "/decay/{study}.nc", study=STUDIES),


rule match_study:
    input:
        decays=RESULTS + "/decay/{study}.nc",
    output:
        RESULTS + "/match/{study}.nc",
    log:
        LOGS + "/match/{study}.log",
    params:
        *SOLVER,
        *settings("wall", "matching"),
        *STUDY_SETTINGS,
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
        decays=RESULTS + "/decay/amplitude.nc",
    output:
        RESULTS + "/response_lengths.nc",
    log:
        LOGS + "/response_lengths.log",
    params:
        *SOLVER,
        *settings("wall", "studies.amplitude", "matching.scan", "response_lengths"),
        *code("studies.response_lengths"),
        *texts("response_lengths"),
        function="studies.response_lengths.response_lengths",
        dataset="response_lengths",
    script:
        "../scripts/dataset.py"


rule damping_force:
    output:
        RESULTS + "/damping_force.nc",
    log:
        LOGS + "/damping_force.log",
    params:
        *SOLVER,
        *settings("matching", "damping_force"),
        *code("studies.damping_force"),
        *texts("damping_force"),
        function="studies.damping_force.damping_force",
        dataset="damping_force",
    script:
        "../scripts/dataset.py"


rule equivalence_fit:
    input:
        matched=RESULTS + "/match/cracked_stiffness.nc",
    output:
        RESULTS + "/equivalence.nc",
    log:
        LOGS + "/equivalence.log",
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
        equivalence=RESULTS + "/equivalence.nc",
    output:
        RESULTS + "/coefficients.csv",
    log:
        LOGS + "/coefficients.log",
    params:
        *code("studies.polynomial_fits"),
        function="studies.polynomial_fits.table",
    script:
        "../scripts/dataset.py"


rule equivalence:
    input:
        RESULTS + "/equivalence.nc",
        RESULTS + "/coefficients.csv",


rule calibration:
    input:
        record=CONFIG.validation.record,
    output:
        RESULTS + "/calibration.nc",
    log:
        LOGS + "/calibration.log",
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
        equivalence=RESULTS + "/equivalence.nc",
        calibration=RESULTS + "/calibration.nc",
    output:
        RESULTS + "/validation.nc",
    log:
        LOGS + "/validation.log",
    params:
        *settings("validation.wall", "validation.curve", "validation.step", "validation.fit_yield_displacement_ratios"),
        *code("studies.validation"),
        *texts("validation"),
        function="studies.validation.validate",
        dataset="validation",
    script:
        "../scripts/dataset.py"


rule bilinear:
    input:
        files_of(CONFIG.bilinear.records),
    output:
        RESULTS + "/bilinear.nc",
    log:
        LOGS + "/bilinear.log",
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
        errata="data/errata.yaml",
        datasets=[
            *MATCHES,
            RESULTS + "/mechanism.nc",
            RESULTS + "/damping_force.nc",
            RESULTS + "/response_lengths.nc",
            RESULTS + "/equivalence.nc",
            RESULTS + "/validation.nc",
            RESULTS + "/bilinear.nc",
        ],
    output:
        table=RESULTS + "/claims.csv",
        structure=RESULTS + "/claims.json",
        errata=RESULTS + "/errata.csv",
    log:
        LOGS + "/claims.log",
    params:
        *code("claims", script="claims"),
        judges="JUDGES",
    script:
        "../scripts/claims.py"
