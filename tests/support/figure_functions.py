"""What draws each figure of the table, by the figure's name."""

from importlib import import_module

from rockdamp.pipeline import figures

FIGURES = {
    name: getattr(import_module(f"rockdamp.figures.{figure.module}"), name) for name, figure in figures.FIGURES.items()
}
