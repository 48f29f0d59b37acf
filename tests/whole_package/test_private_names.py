"""The package, the pipeline and the tools use public names of other packages alone: private ones change unannounced.

And no module defines a name twice: the second would silently stand for the first.
"""

import ast
import re

import pytest
from repository import ROOT

FILES = sorted(path for folder in ("src", "workflow", "tools") for path in (ROOT / folder).rglob("*.py"))
PRIVATE = re.compile(r"(?:^|\.)_(?!_)|^numba\.core")


def private_names(tree):
    """Yield the private names of other packages that a module imports or reaches for, and changes of `sys.modules`."""
    modules = {}  # names that stand for modules of other packages
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            modules |= {each.asname or each.name.partition(".")[0]: each.name for each in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0 and node.module != "__future__":
            modules |= {each.asname or each.name: f"{node.module}.{each.name}" for each in node.names}
    modules = {name: path for name, path in modules.items() if not path.startswith("rockdamp")}
    yield from filter(PRIVATE.search, modules.values())
    for node in ast.walk(tree):
        name, root = "", node
        while isinstance(root, ast.Attribute | ast.Call | ast.Subscript):
            if isinstance(root, ast.Attribute):
                name = f".{root.attr}{name}"
            root = root.func if isinstance(root, ast.Call) else root.value
        if isinstance(root, ast.Name) and root.id in modules and PRIVATE.search(f"{modules[root.id]}{name}"):
            yield ast.unparse(node)
        if isinstance(node, ast.Subscript | ast.Call) and re.match(r"sys\.modules[.[]", ast.unparse(node)):
            yield ast.unparse(node)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_no_private_name_of_another_package_is_used(path):
    assert list(private_names(ast.parse(path.read_text(encoding="utf-8")))) == []


def names_given_by(statement):
    """Return the names that a statement of a module assigns or defines."""
    if isinstance(statement, ast.FunctionDef | ast.ClassDef):
        return [] if statement.decorator_list else [statement.name]  # decorators overload and register
    targets = statement.targets if isinstance(statement, ast.Assign) else []
    targets = [statement.target] if isinstance(statement, ast.AnnAssign) else targets
    each = (node for target in targets for node in getattr(target, "elts", [target]))
    return [node.id for node in each if isinstance(node, ast.Name) and node.id != "_"]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_no_module_gives_a_name_twice(path):
    given = [
        name for statement in ast.parse(path.read_text(encoding="utf-8")).body for name in names_given_by(statement)
    ]
    assert sorted(given) == sorted(set(given))


def test_no_helper_of_the_tests_shadows_an_example():
    """They stand on one path: an example of that name could not be imported, and its test would be of the helper."""
    helpers = {path.stem for folder in ("tests/support", "tools") for path in (ROOT / folder).glob("*.py")}
    assert helpers.isdisjoint(path.stem for path in (ROOT / "examples").rglob("*.py"))
