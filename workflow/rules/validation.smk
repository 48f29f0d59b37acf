"""The models against a measured test: Fig. 8, and the calibration."""


rule validation:
    input:
        record=config["validation"]["record"],
        equivalence=rules.equivalence_fit.output[0],
        code=code("rockdamp.studies.validation"),
    output:
        f"{RESULTS}/validation.nc",
    log:
        f"{LOGS}/validation.log",
    params:
        function="rockdamp.studies.validation.validate",
        kind="validation",
        version=version("rockdamp.studies.validation"),
        config=part(
            "validation.wall",
            "validation.curve",
            "validation.restitution",
            "validation.step",
            "validation.fit_cracked_stiffness_ratios",
        ),
    message:
        "Responses to the measured motion under each damping model"
    script:
        "../scripts/dataset.py"


rule calibration:
    input:
        record=config["validation"]["record"],
        code=code("rockdamp.studies.calibration"),
    output:
        f"{RESULTS}/calibration.nc",
    log:
        f"{LOGS}/calibration.log",
    params:
        function="rockdamp.studies.calibration.study",
        kind="calibration",
        version=version("rockdamp.studies.calibration"),
        config=part(
            "validation.wall",
            "validation.curve.ultimate_ratio",
            "validation.curve.softening",
            "validation.step",
        ),
    message:
        "Curve and coefficient of restitution fitted to the record"
    script:
        "../scripts/dataset.py"
