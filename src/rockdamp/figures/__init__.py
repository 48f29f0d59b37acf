"""The paper's figures: functions from stored datasets to figures. Nothing here simulates."""

from __future__ import annotations

from collections.abc import Callable

from matplotlib.figure import Figure

from rockdamp.figures.accuracy import fig_accuracy, fig_rigid
from rockdamp.figures.collapse import fig_fragility, fig_ida
from rockdamp.figures.curves import fig2
from rockdamp.figures.dispersion import fig_closed_form, fig_dispersion, fig_exponent
from rockdamp.figures.equivalence import fig5, fig6, fig6_error, fig7
from rockdamp.figures.histories import fig3, fig4
from rockdamp.figures.mechanism import fig1
from rockdamp.figures.natural import fig_natural, fig_natural_ratio
from rockdamp.figures.orders import fig_orders
from rockdamp.figures.output import save
from rockdamp.figures.population import fig_population
from rockdamp.figures.pulses import fig_pulses
from rockdamp.figures.spectra import fig_spectra
from rockdamp.figures.validation import fig8

FIGURES: dict[str, Callable[..., Figure]] = {
    "fig1": fig1,
    "fig2": fig2,
    "fig3": fig3,
    "fig4": fig4,
    "fig5": fig5,
    "fig6": fig6,
    "fig6_error": fig6_error,
    "fig7": fig7,
    "fig8": fig8,
    "fig_orders": fig_orders,
    "fig_dispersion": fig_dispersion,
    "fig_exponent": fig_exponent,
    "fig_closed_form": fig_closed_form,
    "fig_pulses": fig_pulses,
    "fig_spectra": fig_spectra,
    "fig_natural": fig_natural,
    "fig_natural_ratio": fig_natural_ratio,
    "fig_ida": fig_ida,
    "fig_fragility": fig_fragility,
    "fig_population": fig_population,
    "fig_accuracy": fig_accuracy,
    "fig_rigid": fig_rigid,
}
__all__ = ["FIGURES", "save"]
