"""What draws each figure of the table and what writes its caption, by the figure's name."""

from importlib import import_module

from rockdamp.pipeline import tables

MODULES = {name: import_module(figure.sources.modules[0]) for name, figure in tables.FIGURES.items()}
FIGURES = {name: getattr(module, name) for name, module in MODULES.items()}
CAPTIONS = {name: getattr(module, f"{name}_caption") for name, module in MODULES.items()}
