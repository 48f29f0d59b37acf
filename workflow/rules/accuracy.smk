"""How accurate the published numbers are."""


rule accuracy:
    input:
        amplitude=f"{RESULTS}/match/amplitude.nc",
        slenderness=f"{RESULTS}/match/slenderness.nc",
        overburden=f"{RESULTS}/match/overburden.nc",
        cracked_stiffness=f"{RESULTS}/match/cracked_stiffness.nc",
        loops=rules.loops.output[0],
        amplitude_decays=f"{RESULTS}/decay/amplitude.nc",
        slenderness_decays=f"{RESULTS}/decay/slenderness.nc",
        overburden_decays=f"{RESULTS}/decay/overburden.nc",
        cracked_stiffness_decays=f"{RESULTS}/decay/cracked_stiffness.nc",
        code=code("rockdamp.studies.accuracy.stage"),
    output:
        f"{RESULTS}/accuracy.nc",
    log:
        f"{LOGS}/accuracy.log",
    params:
        function="rockdamp.studies.accuracy.stage.accuracy",
        kind="accuracy",
        version=version("rockdamp.studies.accuracy.stage"),
        config=part(
            "solver",
            "wall",
            "curve",
            "release_amplitude",
            "studies",
            "matching",
            "loops",
            "validation.wall",
            "validation.curve",
            "validation.restitution",
            "accuracy",
        ),
    message:
        "Errors of the solver, of the damping ratios and of small rotations, and the energy audit"
    script:
        "../scripts/dataset.py"
