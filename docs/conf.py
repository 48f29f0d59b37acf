"""The documents as a site: `make docs`. Pages are Markdown (MyST), formulas MathML; the site needs no network."""

import importlib.metadata
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
sys.path.insert(0, str(HERE / "_extensions"))

project = "rockdamp"
author = copyright = "The rockdamp developers"
release = importlib.metadata.version("rockdamp")

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_click",
    "config_keys",
    "docstrings",
    "mathml",
]
templates_path: list[str] = []
exclude_patterns = ["_extensions", "figures"]

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3

# The notebook shows what is among the results; where they are not built, its source alone is shown.
needed = ["equivalence.nc", "match/amplitude.nc"]
nb_execution_mode = "force" if all((ROOT / "results" / name).is_file() for name in needed) else "off"
nb_execution_raise_on_error = True
nb_execution_timeout = 120

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the docstrings say types, shapes and units
napoleon_google_docstring = False
napoleon_use_param = False
napoleon_use_rtype = False
default_role = "code"
nitpicky = True
smartquotes = False  # -- is an option, not a dash
nitpick_ignore = [
    ("py:class", "ndarray"),
    ("py:class", "shape"),
    ("py:class", "stored"),
    ("py:class", "checkpoints"),
]  # words of a type, not names of a page

html_math_renderer = "mathml"
html_theme = "furo"
html_title = f"rockdamp {release}"
html_show_sphinx = False
html_copy_source = False
html_static_path = ["_static"]
html_css_files = ["site.css"]

linkcheck_timeout = 20
linkcheck_retries = 2


def setup(app):  # a pattern of records, far-field/*, is no emphasis
    for part in ("options", "epilog"):
        app.connect(f"sphinx-click-process-{part}", _without_emphasis)


def _without_emphasis(app, context, lines):
    lines[:] = [line.replace("*", r"\*") for line in lines]
