"""One rule for each figure, which says what it shows; how it shows it is in rockdamp.figures."""

FIGURES = [
    "fig1",
    "fig2",
    "fig3",
    "fig4",
    "fig5",
    "fig6",
    "fig6_error",
    "fig7",
    "fig8",
    "fig_orders",
    "fig_dispersion",
    "fig_exponent",
    "fig_closed_form",
    "fig_pulses",
    "fig_spectra",
    "fig_natural",
    "fig_natural_ratio",
    "fig_ida",
    "fig_fragility",
    "fig_population",
    "fig_accuracy",
    "fig_rigid",
]


rule fig1:
    input:
        rules.mechanism.output,
        code=code("rockdamp.figures"),
    output:
        figure("fig1"),
    log:
        f"{LOGS}/figures/fig1.log",
    params:
        version=version("rockdamp.figures"),
        config=part("figures"),
    message:
        "Fig. 1: the mechanism, at rest and displaced"
    script:
        "../scripts/figure.py"


use rule fig1 as fig2 with:
    output:
        figure("fig2"),
    log:
        f"{LOGS}/figures/fig2.log",
    message:
        "Fig. 2: force-displacement curves"


use rule fig1 as fig3 with:
    input:
        rules.loops.output,
        code=code("rockdamp.figures"),
    output:
        figure("fig3"),
    log:
        f"{LOGS}/figures/fig3.log",
    message:
        "Fig. 3: damping laws and loops"


use rule fig3 as fig4 with:
    output:
        figure("fig4"),
    log:
        f"{LOGS}/figures/fig4.log",
    message:
        "Fig. 4: decays"


use rule fig1 as fig5 with:
    input:
        expand(rules.match_study.output, study="amplitude"),
        code=code("rockdamp.figures"),
    output:
        figure("fig5"),
    log:
        f"{LOGS}/figures/fig5.log",
    message:
        "Fig. 5: damping ratios and amplitude"


use rule fig1 as fig6 with:
    input:
        expand(rules.match_study.output, study=["slenderness", "overburden", "cracked_stiffness"]),
        code=code("rockdamp.figures"),
    output:
        figure("fig6"),
    log:
        f"{LOGS}/figures/fig6.log",
    message:
        "Fig. 6: damping ratios and slenderness, overburden and cracked stiffness"


use rule fig5 as fig6_error with:
    output:
        figure("fig6_error"),
    log:
        f"{LOGS}/figures/fig6_error.log",
    message:
        "The paper's second Fig. 6: errors of the matches"


use rule fig1 as fig7 with:
    input:
        rules.equivalence_fit.output,
        code=code("rockdamp.figures"),
    output:
        figure("fig7"),
    log:
        f"{LOGS}/figures/fig7.log",
    message:
        "Fig. 7: polynomials of the damping ratio"


use rule fig1 as fig8 with:
    input:
        rules.validation.output,
        code=code("rockdamp.figures"),
    output:
        figure("fig8"),
    log:
        f"{LOGS}/figures/fig8.log",
    message:
        "Fig. 8: responses to the measured motion"


use rule fig1 as fig_orders with:
    input:
        rules.orders.output,
        code=code("rockdamp.figures"),
    output:
        figure("fig_orders"),
    log:
        f"{LOGS}/figures/fig_orders.log",
    message:
        "Order of convergence of both schemes"


use rule fig1 as fig_dispersion with:
    input:
        rules.dispersion.output,
        code=code("rockdamp.figures"),
    output:
        figure("fig_dispersion"),
    log:
        f"{LOGS}/figures/fig_dispersion.log",
    message:
        "How the damping ratio depends on the amplitude"


use rule fig_dispersion as fig_exponent with:
    output:
        figure("fig_exponent"),
    log:
        f"{LOGS}/figures/fig_exponent.log",
    message:
        "The exponent with which the damping ratio depends least on the amplitude"


use rule fig_dispersion as fig_closed_form with:
    output:
        figure("fig_closed_form"),
    log:
        f"{LOGS}/figures/fig_closed_form.log",
    message:
        "The closed form against peaks and against Err"


use rule fig1 as fig_pulses with:
    input:
        rules.pulses.output,
        code=code("rockdamp.figures"),
    output:
        figure("fig_pulses"),
    log:
        f"{LOGS}/figures/fig_pulses.log",
    message:
        "The dampers against restitution under pulses"


use rule fig_pulses as fig_spectra with:
    output:
        figure("fig_spectra"),
    log:
        f"{LOGS}/figures/fig_spectra.log",
    message:
        "Rocking spectra of pulses"


use rule fig1 as fig_natural with:
    input:
        rules.natural_study.output,
        rules.comparison.output,
        code=code("rockdamp.figures"),
    output:
        figure("fig_natural"),
    log:
        f"{LOGS}/figures/fig_natural.log",
    message:
        "Peaks of the dampers under earthquakes against those with restitution"


use rule fig1 as fig_natural_ratio with:
    input:
        rules.comparison.output,
        code=code("rockdamp.figures"),
    output:
        figure("fig_natural_ratio"),
    log:
        f"{LOGS}/figures/fig_natural_ratio.log",
    message:
        "Errors of the dampers under earthquakes by amplitude"


use rule fig_natural_ratio as fig_ida with:
    output:
        figure("fig_ida"),
    log:
        f"{LOGS}/figures/fig_ida.log",
    message:
        "Incremental dynamic analyses of every wall"


use rule fig_natural_ratio as fig_fragility with:
    output:
        figure("fig_fragility"),
    log:
        f"{LOGS}/figures/fig_fragility.log",
    message:
        "Fragility of every wall"


use rule fig1 as fig_population with:
    input:
        rules.population.output,
        code=code("rockdamp.figures"),
    output:
        figure("fig_population"),
    log:
        f"{LOGS}/figures/fig_population.log",
    message:
        "Fragility of a population of walls, and what it depends on"


use rule fig1 as fig_accuracy with:
    input:
        rules.accuracy.output,
        code=code("rockdamp.figures"),
    output:
        figure("fig_accuracy"),
    log:
        f"{LOGS}/figures/fig_accuracy.log",
    message:
        "Errors of the solver and of the damping ratios"


use rule fig_accuracy as fig_rigid with:
    output:
        figure("fig_rigid"),
    log:
        f"{LOGS}/figures/fig_rigid.log",
    message:
        "Where small rotations and the mass of slender bodies start to matter"
