"""The list of mutations, tools/mutations.yaml: the text that each one replaces stands in its file.

`tools/mutate.py` sees that a test notices each; it takes minutes and is run by hand.
"""

import ast

import yaml
from mutate import Mutation
from repository import ROOT

MUTATIONS = [Mutation(**entry) for entry in yaml.safe_load((ROOT / "tools/mutations.yaml").read_text(encoding="utf-8"))]


def applies(mutation):
    path = ROOT / "src/rockdamp" / mutation.file
    text = path.read_text(encoding="utf-8") if path.is_file() else ""
    wrong = text.replace(mutation.right, mutation.wrong)
    if path.suffix != ".py":  # a template
        return wrong != text
    return wrong != text and ast.dump(ast.parse(wrong)) != ast.dump(ast.parse(text))  # no mere change of a comment


def test_each_mutation_finds_its_text_and_names_tests_that_exist():
    assert [mutation.name for mutation in MUTATIONS if not applies(mutation)] == []
    tests = {test.partition("::")[0] for mutation in MUTATIONS for test in mutation.tests}
    assert [test for test in sorted(tests) if not (ROOT / "tests" / test).is_file()] == []


def test_no_two_mutations_have_one_name():
    assert len({mutation.name for mutation in MUTATIONS}) == len(MUTATIONS)
