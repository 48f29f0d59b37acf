"""Files from outside, attacked at random. `tools/hurt.py` attacks more of them, and the writer."""

from collections import Counter
from itertools import islice

import pytest
from attacks import ANSWER, REFUSED, ended
from command_attacks import command_attacks
from record_attacks import record_attacks
from repository import ROOT

SEED, COUNT = 23, 150


def test_an_attacked_record_ends_in_the_right_answer_or_in_a_refusal(tmp_path):
    seen = Counter()
    for number, attack in enumerate(islice(record_attacks(SEED), COUNT)):
        folder = tmp_path / str(number)
        folder.mkdir()
        how = ended(attack, folder)
        assert how in (ANSWER, REFUSED), f"{attack.kind}: {how}"
        seen[how] += 1
    assert min(seen[ANSWER], seen[REFUSED]) > 5


@pytest.mark.parametrize("kind", ["lists", "outputs", "raw tables", "priors"])
def test_a_mistyped_command_ends_in_the_right_answer_or_in_a_refusal_that_writes_nothing(kind, tmp_path):
    seen = Counter()
    for number, attack in enumerate(islice(command_attacks(SEED, kind), 12)):
        folder = tmp_path / str(number)
        folder.mkdir()
        how = ended(attack, folder)
        assert how in (ANSWER, REFUSED), f"{attack.kind}: {how}"
        seen[how] += 1
    assert min(seen[ANSWER], seen[REFUSED]) > 0


def test_the_page_tells_how_each_part_ended():
    page = (ROOT / "docs/robustness.md").read_text(encoding="utf-8").partition("<!-- end -->")[0]
    rows = [line.split(" | ") for line in page.splitlines() if line.startswith("| ")][1:]
    assert {row[0][2:] for row in rows} >= {"inputs", "commands", "writer", "resources"}
    assert all(row[-1] == "ok |" for row in rows)
