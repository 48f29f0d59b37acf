"""Figures: functions from stored datasets to Matplotlib figures, each in a module named after what it shows.

Nothing here simulates. What the report says of a figure stands in report/figures.yaml.
"""

# Each figure's module, with a function of the figure's name, and the datasets that the function is given.
FIGURES = {
    "fig1": ("figures.mechanism", ["mechanism"]),
    "fig2": ("figures.mechanism", ["mechanism"]),
    "fig3": ("figures.histories", ["damping_force"]),
    "fig4": ("figures.histories", ["damping_force"]),
    "fig5": ("figures.equivalence", ["match/amplitude"]),
    "fig6": ("figures.equivalence", ["match/slenderness", "match/overburden", "match/cracked_stiffness"]),
    "fig6_error": ("figures.equivalence", ["match/amplitude"]),
    "fig7": ("figures.equivalence", ["equivalence"]),
    "fig8": ("figures.validation", ["validation"]),
    "fig_convergence": ("figures.convergence", ["convergence"]),
    "fig_amplitude": ("figures.amplitude", ["amplitude"]),
    "fig_order": ("figures.order", ["order"]),
    "fig_loss_law": ("figures.assumptions", ["loss_law"]),
    "fig_supports": ("figures.assumptions", ["supports"]),
    "fig_earthquakes": ("figures.earthquakes", ["earthquakes", "comparison"]),
    "fig_earthquakes_ratio": ("figures.earthquakes", ["comparison"]),
    "fig_ida": ("figures.collapse", ["comparison", "earthquakes/walls"]),
    "fig_fragility": ("figures.collapse", ["comparison", "earthquakes/walls"]),
    "fig_measured_rocking": ("laboratory.figures", ["measured_rocking"]),
}
