"""Decays under restitution, the viscous damping that matches them, and how the two relate: Figs 3 to 7."""


rule decay_study:
    input:
        code=code("rockdamp.studies.decays"),
    output:
        f"{RESULTS}/decay/{{study}}.nc",
    log:
        f"{LOGS}/decay/{{study}}.log",
    params:
        function="rockdamp.studies.decays.study",
        kind="decay",
        version=version("rockdamp.studies.decays"),
        config=part("solver", "wall", "curve", "release_amplitude", "restitution", "studies.{study}", "windows.stop"),
    message:
        "Free decays under a coefficient of restitution: the {wildcards.study} study"
    script:
        "../scripts/dataset.py"


rule decay:
    input:
        expand(rules.decay_study.output, study=STUDIES),
    message:
        "The free decays of every study"


rule match_study:
    input:
        decays=rules.decay_study.output[0],
        code=code("rockdamp.studies.matches"),
    output:
        f"{RESULTS}/match/{{study}}.nc",
    log:
        f"{LOGS}/match/{{study}}.log",
    params:
        function="rockdamp.studies.matches.match",
        kind="match",
        version=version("rockdamp.studies.matches"),
        config=part("solver", "wall", "curve", "release_amplitude", "studies.{study}", "matching"),
    message:
        "Damping ratios with the least error, Eq. (17): the {wildcards.study} study"
    script:
        "../scripts/dataset.py"


rule match:
    input:
        expand(rules.match_study.output, study=STUDIES),
    message:
        "The matched damping ratios of every study"


rule windows:
    input:
        decays=f"{RESULTS}/decay/amplitude.nc",
        code=code("rockdamp.studies.response_length"),
    output:
        f"{RESULTS}/windows.nc",
    log:
        f"{LOGS}/windows.log",
    threads: 2
    params:
        function="rockdamp.studies.response_length.windows",
        kind="windows",
        version=version("rockdamp.studies.response_length"),
        config=part("solver", "wall", "curve", "release_amplitude", "studies.amplitude", "matching.scan", "windows"),
    message:
        "Errors and damping ratios for every length of the response"
    script:
        "../scripts/dataset.py"


rule equivalence_fit:
    input:
        matched=f"{RESULTS}/match/cracked_stiffness.nc",
        code=code("rockdamp.studies.polynomial_fits"),
    output:
        f"{RESULTS}/equivalence.nc",
    log:
        f"{LOGS}/equivalence.log",
    params:
        function="rockdamp.studies.polynomial_fits.fit",
        kind="equivalence",
        version=version("rockdamp.studies.polynomial_fits"),
        config=part("curve.plateau_ratio", "curve.ultimate_ratio", "release_amplitude"),
    message:
        "Second-order polynomials of the damping ratio over the coefficient of restitution"
    script:
        "../scripts/dataset.py"


rule coefficients:
    input:
        fits=rules.equivalence_fit.output[0],
        code=code("rockdamp.studies.polynomial_fits"),
    output:
        f"{RESULTS}/coefficients.csv",
    log:
        f"{LOGS}/coefficients.log",
    params:
        function="rockdamp.studies.polynomial_fits.table",
        version=version("rockdamp.studies.polynomial_fits"),
    message:
        "The polynomials as a table"
    script:
        "../scripts/table.py"


rule equivalence:
    input:
        rules.equivalence_fit.output,
        rules.coefficients.output,
    message:
        "The polynomials, as a dataset and as a table"


rule loops:
    input:
        code=code("rockdamp.studies.damping_loops"),
    output:
        f"{RESULTS}/loops.nc",
    log:
        f"{LOGS}/loops.log",
    params:
        function="rockdamp.studies.damping_loops.loops",
        kind="loops",
        version=version("rockdamp.studies.damping_loops"),
        config=part("solver", "curve", "release_amplitude", "matching", "loops"),
    message:
        "Matched histories, their damping forces, and rigid rocking"
    script:
        "../scripts/dataset.py"


rule mechanism:
    input:
        code=code("rockdamp.studies.force_curves"),
    output:
        f"{RESULTS}/mechanism.nc",
    log:
        f"{LOGS}/mechanism.log",
    params:
        function="rockdamp.studies.force_curves.mechanism",
        kind="mechanism",
        version=version("rockdamp.studies.force_curves"),
        config=part("wall", "curve"),
    message:
        "Force-displacement curves and the wall's geometry"
    script:
        "../scripts/dataset.py"


rule dispersion:
    input:
        code=code("rockdamp.studies.amplitude_dispersion"),
    output:
        f"{RESULTS}/dispersion.nc",
    log:
        f"{LOGS}/dispersion.log",
    threads: 2
    params:
        function="rockdamp.studies.amplitude_dispersion.dispersion",
        kind="dispersion",
        version=version("rockdamp.studies.amplitude_dispersion"),
        config=part(
            "solver",
            "curve.plateau_ratio",
            "studies.cracked_stiffness.plateau_ratio_beyond",
            "matching",
            "dispersion",
        ),
    message:
        "Dispersion of the damping ratio over the amplitude, by peaks, by Err and by the closed form"
    script:
        "../scripts/dataset.py"


rule pulses:
    input:
        code=code("rockdamp.studies.pulses"),
    output:
        f"{RESULTS}/pulses.nc",
    log:
        f"{LOGS}/pulses.log",
    threads: 2
    params:
        function="rockdamp.studies.pulses.pulses",
        kind="pulses",
        version=version("rockdamp.studies.pulses"),
        config=part("solver", "curve", "release_amplitude", "matching", "pulses"),
    message:
        "The dampers against restitution under pulses"
    script:
        "../scripts/dataset.py"


rule orders:
    input:
        code=code("rockdamp.studies.accuracy.convergence"),
    output:
        f"{RESULTS}/orders.nc",
    log:
        f"{LOGS}/orders.log",
    params:
        function="rockdamp.studies.accuracy.convergence.orders",
        kind="orders",
        version=version("rockdamp.studies.accuracy.convergence"),
        config=part("convergence"),
    message:
        "Order of convergence of both schemes, for each damper"
    script:
        "../scripts/dataset.py"
