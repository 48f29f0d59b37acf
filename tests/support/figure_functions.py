"""What draws each figure of the table, by the figure's name."""

from importlib import import_module

from rockdamp import figures

FIGURES = {name: getattr(import_module(f"rockdamp.{module}"), name) for name, (module, _) in figures.FIGURES.items()}
INPUTS = {name: datasets for name, (_, datasets) in figures.FIGURES.items()}
