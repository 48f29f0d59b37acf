"""What is read from outside, attacked at random; the writer with a fault at each of its calls; what many calls hold."""

import random
import re
import time
from collections import Counter
from itertools import islice

import attacks
import faults
import numpy as np
import pytest
import record_attacks
import table_attacks
from attacks import ANSWER, REFUSED, Attack, ended
from command_attacks import command_attacks
from config_attacks import config_attacks
from record_attacks import Meant
from repository import ROOT

SEED, COUNT = 23, 150


ENDLESS = [record_attacks.record_attacks, config_attacks, command_attacks, table_attacks.table_attacks]


@pytest.mark.parametrize("endless", ENDLESS)
def test_an_attack_ends_in_the_right_answer_or_in_a_refusal(tmp_path, endless):
    found = Counter()
    for number, attack in enumerate(islice(endless(SEED), COUNT)):
        folder = tmp_path / str(number)
        folder.mkdir()
        how = ended(attack, folder)
        assert how in (ANSWER, REFUSED), f"{attack.kind}: {how}"
        found[how] += 1
    assert min(found[ANSWER], found[REFUSED]) > 5


def test_a_record_that_is_read_as_another_is_found_out(tmp_path):
    text = record_attacks._csv(header=("# synthetic: yes",)).encode()

    def judged(motion, synthetic=True):
        return record_attacks._reader(Meant(text, ".csv", motion, synthetic))(tmp_path)

    right = record_attacks.MOTION
    assert judged(right) == ANSWER
    assert judged(1.001 * right) == judged(right[:-1]) == "another motion than the file's"
    assert judged(None) == "an answer to what means nothing"
    assert judged(right, synthetic=False) == "another label than the file's"


def test_a_table_that_is_read_as_another_is_found_out(tmp_path, monkeypatch):
    walls = [{"id": name, "thickness": "0.3", "height": "3", "preset": "new", "restitution": "0.8"} for name in "ab"]
    text = table_attacks._text(random.Random(SEED), walls).encode()

    def judged(rows):
        return table_attacks._judge(table_attacks.Meant(text, rows))(tmp_path)

    first, second = table_attacks._means(walls)
    assert judged([first, second]) == ANSWER
    assert judged(None) == "an answer to what is no table"
    assert judged([first]) == judged([second, first]) == "other rows than the table's"
    assert judged([first, ("b", None)]) == "an answer to a row that makes no wall"
    for other in (
        {"thickness": "0.31"},
        {"preset": "severe"},
        {"restitution": "0.81"},
        {"parapet": "yes"},
        {"a1": "0.2"},
    ):
        assert judged([first, ("b", walls[1] | other)]) == "another wall than the row's"
    monkeypatch.setattr(table_attacks, "THICKEST", 0.2)
    assert judged([first, second]) == "a wall of another unit passes"


def test_a_hang_and_an_exception_of_another_package_are_found_out(tmp_path, monkeypatch):
    monkeypatch.setattr(attacks, "PATIENCE", 1)
    assert ended(Attack("made up", lambda _: time.sleep(5)), tmp_path) == "hangs for more than 1 s"
    assert ended(Attack("made up", lambda _: {}["x"]), tmp_path) == "KeyError: 'x'"


def test_a_fault_at_any_call_of_a_writer_leaves_the_old_result_or_the_new_one(tmp_path):
    found = Counter()
    for number, (name, run) in enumerate(faults.writer_attacks()):
        if name.startswith("result.png"):
            continue  # drawing takes a while: tools/hurt.py
        folder = tmp_path / str(number)
        folder.mkdir()
        how = run(folder)
        assert how in (ANSWER, REFUSED), f"{name}: {how}"
        found[how] += 1
    assert found[REFUSED] > 40


def test_a_writer_that_writes_in_place_is_found_out(tmp_path, monkeypatch):
    def in_place(path, number):
        path.write_bytes(b"1" * int(number))
        (path.parent / "more").write_bytes(b"2")

    def halves(path, number):
        path.write_bytes(b"")
        path.write_bytes(b"1" * int(number))

    for name, write, how in (("left", in_place, r"\['more'\] left"), ("half", halves, "half a result")):
        monkeypatch.setattr(faults, "WRITERS", {name: write})
        found = []
        for number, (_, run) in enumerate(faults.writer_attacks()):
            folder = tmp_path / f"{name}{number}"
            folder.mkdir()
            found.append(run(folder))
        assert any(re.fullmatch(how, each) for each in found), found


def test_calls_hold_nothing(tmp_path):
    for _ in range(10):
        faults.call_once(tmp_path)
    before = faults.held()
    for _ in range(20):
        faults.call_once(tmp_path)
    after = faults.held()
    assert (after["threads"], after["files"]) == (before["threads"], before["files"])
    assert after["memory"] - before["memory"] < 20
    kept = np.ones(2**25)  # 256 MB are seen
    assert faults.held()["memory"] - after["memory"] > 20 + kept.nbytes / 2**21


def test_the_page_tells_how_each_part_ended():
    page = (ROOT / "docs/robustness.md").read_text(encoding="utf-8")
    rows = [line.split(" | ") for line in page.splitlines() if line.startswith("| ")][1:]
    assert {row[0][2:] for row in rows} >= {"inputs", "writer", "resources"}
    assert all(row[-1] == "ok |" for row in rows)
