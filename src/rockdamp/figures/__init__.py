"""Figures: functions from stored datasets to Matplotlib figures.

Nothing here simulates. Titles and captions are in report/figures.yaml.
"""

# By figure: the module, which has a function of the figure's name, and the datasets that are the
# arguments of this function, in their order.
FIGURES = {
    "fig1": ("figures.mechanism", ["mechanism"]),
    "fig2": ("figures.mechanism", ["mechanism"]),
    "fig3": ("figures.decays", ["damping_force"]),
    "fig4": ("figures.decays", ["damping_force"]),
    "fig5": ("figures.equivalence", ["match/amplitude"]),
    "fig6": (
        "figures.equivalence",
        ["match/slenderness", "match/overburden", "match/cracked_stiffness"],
    ),
    "fig6_error": ("figures.equivalence", ["match/amplitude"]),
    "fig7": ("figures.equivalence", ["equivalence"]),
    "fig8": ("figures.measured", ["validation"]),
    "fig_convergence": ("figures.assumptions", ["convergence"]),
    "fig_amplitude": ("figures.equivalence", ["amplitude"]),
    "fig_order": ("figures.order", ["order"]),
    "fig_loss_law": ("figures.assumptions", ["loss_law"]),
    "fig_supports": ("figures.assumptions", ["supports"]),
    "fig_earthquakes": ("figures.earthquakes", ["comparison"]),
    "fig_fragility": ("figures.earthquakes", ["comparison"]),
    "fig_measured_rocking": ("figures.measured", ["measured_rocking"]),
}
