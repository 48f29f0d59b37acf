"""The list of mutations, tools/mutations.yaml: each can be made, and none of the package's modules is left out.

That each is noticed takes minutes: tools/mutate.py, by hand.
"""

import ast

import pytest
import yaml
from mutate import Mutation
from repository import ROOT

PACKAGE = ROOT / "src/rockdamp"
MUTATIONS = [Mutation(**entry) for entry in yaml.safe_load((ROOT / "tools/mutations.yaml").read_text(encoding="utf-8"))]
WITHOUT = {  # modules with a function, and why no equation of theirs can be wrong
    "__init__.py": "passes names on; tests of its types hold them equal to the modules'",
    "cli/__init__.py": "puts commands together",
}


def has_logic(text):
    """Whether a module computes anything: one that holds names, numbers or fields alone has no function."""
    return any(isinstance(node, ast.FunctionDef | ast.Lambda) for node in ast.walk(ast.parse(text)))


def test_every_module_with_logic_is_mutated_but_those_of_which_it_is_said_why():
    modules = {path.relative_to(PACKAGE).as_posix(): path for path in PACKAGE.rglob("*.py")}
    with_logic = {name for name, path in modules.items() if has_logic(path.read_text(encoding="utf-8"))}
    mutated = {mutation.file for mutation in MUTATIONS}
    assert with_logic - mutated - set(WITHOUT) == set()
    assert set(WITHOUT) <= with_logic - mutated  # each exception still is one


def test_no_two_mutations_have_one_name_or_are_the_same():
    assert len({mutation.name for mutation in MUTATIONS}) == len(MUTATIONS)
    assert len({(mutation.file, mutation.right, mutation.wrong) for mutation in MUTATIONS}) == len(MUTATIONS)


@pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda mutation: mutation.name)
def test_a_mutation_finds_its_text_and_leaves_a_module_that_runs(mutation):
    text = (PACKAGE / mutation.file).read_text(encoding="utf-8")
    assert mutation.right in text
    wrong = text.replace(mutation.right, mutation.wrong)
    assert ast.dump(ast.parse(wrong)) != ast.dump(ast.parse(text))  # no mere change of layout or of a comment
    for test in mutation.tests:
        assert (ROOT / "tests" / test.partition("::")[0]).is_file(), test
