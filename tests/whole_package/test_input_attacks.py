"""Files from outside, attacked at random. `tools/hurt.py` attacks more of them, and the writer."""

from collections import Counter
from itertools import islice

import numpy as np
import pytest
from attacks import ANSWER, REFUSED, ended
from command_attacks import command_attacks
from hypothesis import given
from hypothesis import strategies as st
from record_attacks import record_attacks
from repository import ROOT

import rockdamp as rd
from rockdamp.assessment.table import BadRow, read_walls

SEED, COUNT = 23, 150
WALLS = (ROOT / "examples/my-walls.csv").read_bytes()
BYTES = [b"", b"\x00", b"\n", b",", b'"', b"\xff", b"-", b"e9", b"1_0", b"nan", b";", "\u0661".encode()]


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


@given(st.lists(st.tuples(st.integers(0, len(WALLS)), st.sampled_from(BYTES), st.integers(0, 8)), max_size=4))
def test_an_edited_table_of_walls_has_rows_that_are_walls_or_are_refused_by_their_line(tmp_path_factory, edits):
    path, content = tmp_path_factory.getbasetemp() / "walls.csv", WALLS
    for at, put, removed in edits:
        content = content[:at] + put + content[at + removed :]
    path.write_bytes(content)
    try:
        rows = read_walls(path)
    except rd.InputError as error:
        assert "walls.csv" in str(error) and len(str(error).splitlines()) == 1
        return
    for row in rows:
        if isinstance(row, BadRow):
            assert row.error.startswith(f"line {row.line}: ")
        else:
            assert (
                np.isfinite([row.wall.thickness, row.wall.height, row.wall.density]).all() and 0 < row.restitution <= 1
            )


def test_the_page_tells_how_each_part_ended():
    page = (ROOT / "docs/robustness.md").read_text(encoding="utf-8").partition("<!-- end -->")[0]
    rows = [line.split(" | ") for line in page.splitlines() if line.startswith("| ")][1:]
    assert {row[0][2:] for row in rows} >= {"inputs", "commands", "writer", "resources"}
    assert all(row[-1] == "ok |" for row in rows)
