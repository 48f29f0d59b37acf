"""Formulas as MathML, by docutils' own converter: browsers draw them without a script and without the network."""

import re

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml

TAG = re.compile(r"\\tag\{(?P<number>.*?)\}")
BARE = re.compile(r"\\frac\s*[^{\s]")


def convert(tex, as_block):
    """Convert a formula; of a fraction without braces docutils would make another one."""
    if BARE.search(tex):
        raise ValueError(f"the parts of \\frac must stand in braces: {tex}")
    return tex2mathml(tex, as_block=as_block)


def visit_inline(self, node):
    self.body.append(convert(node.astext(), as_block=False))
    raise nodes.SkipNode


def visit_block(self, node):
    tex = node.astext()
    number = TAG.search(tex)
    self.body.append(self.starttag(node, "div", CLASS="math"))
    if number:
        self.body.append(f'<span class="eqno">({self.encode(number["number"])})</span>')
    self.body.append(convert(TAG.sub("", tex), as_block=True) + "</div>\n")
    raise nodes.SkipNode


def setup(app):
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
