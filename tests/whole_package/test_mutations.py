"""The list of mutations, tools/mutations.yaml: each can be made.

That each is noticed takes minutes: tools/mutate.py, by hand. It also lists the modules that have none.
"""

import ast

import pytest
import yaml
from mutate import Mutation
from repository import ROOT

PACKAGE = ROOT / "src/rockdamp"
MUTATIONS = [Mutation(**entry) for entry in yaml.safe_load((ROOT / "tools/mutations.yaml").read_text(encoding="utf-8"))]


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
