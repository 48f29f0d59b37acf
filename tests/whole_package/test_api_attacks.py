"""No wrong argument of a public function ends in another package's exception, or is taken for what it is not."""

from collections import Counter
from itertools import islice

import pytest
from api_attacks import CALLS, MADE_BY_OTHERS, Attack, attacks, outcome, parameters

import rockdamp as rd

SEED, COUNT = 14, 3000


@pytest.fixture(autouse=True)
def folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_wrong_arguments_are_refused_by_name_and_nothing_else_happens():
    ended: Counter[str] = Counter()
    for attack in islice(attacks(SEED), COUNT):
        found = outcome(attack)
        shown = {name: type(attack.given[name]).__name__ for name in attack.changed}
        assert found in ("answer", "refused"), f"{attack.name} with {shown}: {found}"
        ended[found] += 1
    assert min(ended["answer"], ended["refused"]) > COUNT / 10  # both are tried


def test_every_public_function_is_attacked_in_every_argument():
    assert {name.partition(".")[0] for name in CALLS} >= set(rd.__all__) - MADE_BY_OTHERS
    for name, call in CALLS.items():
        assert parameters(name) <= set(call.kinds) | {"header", "digest", "unit_of_file", "model"}, name


def test_the_attack_sees_what_it_is_meant_to_see():
    def judged(function, wrong=True):
        return outcome(Attack("made up", function, {"x": None}, ("x",), wrong))

    def refuse(x):
        raise rd.InputError("x is None")

    def crash(x):
        raise AttributeError("no such thing")

    assert judged(refuse) == "refused" and judged(lambda x: x, wrong=False) == "answer"
    assert judged(lambda x: x) == "answer taken from what is none"
    assert judged(crash) == "AttributeError: no such thing"
