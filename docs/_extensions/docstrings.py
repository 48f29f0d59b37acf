"""Docstrings that are plain text to read in a terminal: what reStructuredText would take for markup is made text."""

import re

from sphinx.util.docstrings import prepare_docstring


def escape(app, what, name, obj, options, lines):
    """Before napoleon: |u| is no substitution."""
    for number, line in enumerate(lines):
        if "`" not in line and ">>>" not in line:
            lines[number] = line.replace("|", "\\|")


def restore(app, what, name, obj, options, lines):
    """After napoleon, which takes what stands before a colon for the type of a property."""
    if what == "property":
        lines[:] = prepare_docstring(obj.__doc__)
        escape(app, what, name, obj, options, lines)


def escape_patterns(app, ctx, lines):
    """The help of a command is plain text: of its patterns of files the stars are none of reStructuredText's."""
    lines[:] = [re.sub(r"(?<=[/\]])\*", r"\\*", line) for line in lines]


def leave_out(app, what, name, obj, skip, options):
    """Skip members of Python's own classes, as exceptions and named tuples have: the package describes its own."""
    function = getattr(obj, "fget", None) or getattr(obj, "func", None) or obj  # of a property
    return None if str(getattr(function, "__module__", "")).startswith("rockdamp") else True


def setup(app):
    for part in ("options", "epilog"):
        app.connect(f"sphinx-click-process-{part}", escape_patterns)
    app.connect("autodoc-skip-member", leave_out)
    app.connect("autodoc-process-docstring", escape, priority=400)
    app.connect("autodoc-process-docstring", restore, priority=600)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
