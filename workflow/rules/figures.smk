"""One rule for each figure, which says what it shows; how it shows it is in rockdamp.figures."""

FIGURES = ["fig1", "fig2", "fig3", "fig4", "fig5", "fig6", "fig6_error", "fig7", "fig8", "fig_orders"]


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
