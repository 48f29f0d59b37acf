"""Formulas as MathML, by docutils' own converter: browsers draw them without a script and without
the network.
"""

import re

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml

TAG = re.compile(r"\\tag\{(.*?)\}")


def visit_inline(self, node):
    self.body.append(tex2mathml(node.astext(), as_block=False))
    raise nodes.SkipNode


def visit_block(self, node):
    tex = node.astext()
    number = "".join(f'<span class="eqno">({self.encode(tag)})</span>' for tag in TAG.findall(tex))
    block = tex2mathml(TAG.sub("", tex), as_block=True)
    self.body.append(f"{self.starttag(node, 'div', CLASS='math')}{number}{block}</div>\n")
    raise nodes.SkipNode


def setup(app):
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
