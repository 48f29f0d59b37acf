"""The documents as a site: `make docs`. Pages are Markdown (MyST), formulas MathML; the site needs
no network.
"""

import importlib.metadata
import sys
from pathlib import Path

from sphinx.util.docstrings import prepare_docstring

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
    "mathml",
]
templates_path: list[str] = []
exclude_patterns = ["_extensions", "figures"]

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3

# The notebook shows what is among the results; where they are not built, its source alone is shown.
needed = ["equivalence.nc", "match/amplitude.nc"]
nb_execution_mode = (
    "force" if all((ROOT / "results" / name).is_file() for name in needed) else "off"
)
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


def escape_bars(app, what, name, obj, options, lines):
    """|u| in a docstring is no substitution of reStructuredText."""
    lines[:] = [
        line if "`" in line or ">>>" in line else line.replace("|", r"\|") for line in lines
    ]


def restore_property(app, what, name, obj, options, lines):
    """What stands before a colon in the docstring of a property is not its type, as napoleon has
    it.
    """
    if what == "property":
        lines[:] = prepare_docstring(obj.__doc__)
        escape_bars(app, what, name, obj, options, lines)


def escape_stars(app, context, lines):
    """A pattern of records, far-field/*, is no emphasis."""
    lines[:] = [line.replace("*", r"\*") for line in lines]


def skip_foreign(app, what, name, obj, skip, options):
    """Skip what Python's own classes bring, as exceptions and named tuples do."""
    function = getattr(obj, "fget", None) or getattr(obj, "func", None) or obj  # of a property
    return None if str(getattr(function, "__module__", "")).startswith("rockdamp") else True


def setup(app):
    app.connect("autodoc-process-docstring", escape_bars, priority=400)  # before napoleon
    app.connect("autodoc-process-docstring", restore_property, priority=600)  # after it
    app.connect("autodoc-skip-member", skip_foreign)
    for part in ("options", "epilog"):
        app.connect(f"sphinx-click-process-{part}", escape_stars)
