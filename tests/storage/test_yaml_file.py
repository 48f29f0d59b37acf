"""YAML 1.2: its numbers, keys that stand there once, and no document that fills the memory."""

import math

import pytest
import yaml
from repository import ROOT

from rockdamp.storage import yaml_file


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("010", 10),
        ("0o10", 8),
        ("0x1F", 31),
        ("+1", 1),
        ("1e3", 1000.0),
        ("1.", 1.0),
        (".5", 0.5),
        ("-.5e-1", -0.05),
        (".inf", math.inf),
        ("-.INF", -math.inf),
        ("1e-320", 1e-320),
        ("9" * 401, math.inf),
        ("-" + "9" * 5000, -math.inf),
        ("1:30", "1:30"),
        ("1_0", "1_0"),
        ("yes", "yes"),
        ("off", "off"),
        ("2020-01-01", "2020-01-01"),
        ("0b1", "0b1"),
        ("\u0661", "\u0661"),
        ("true", True),
        ("FALSE", False),
        ("~", None),
        ("", None),
        ("'010'", "010"),
    ],
)
def test_values_are_those_of_the_core_schema(text, value):
    loaded = yaml_file.load(f"a: {text}")["a"]
    assert loaded == value and type(loaded) is type(value)
    assert yaml_file.load(f"[{text or '~'}]") == [value]


def test_nan_is_a_number():
    assert math.isnan(yaml_file.load(".nan"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: 1\nb: 2\na: 1\n", "'a' stands there more than once, first on line 1"),
        ("x: {a: {b: 1, b: 1}}", "'b' stands there more than once"),
        ("- {1: a, 1: b}", "'1' stands there more than once"),
        ('{"a": 1, a: 2}', "'a' stands there more than once"),
        ("a: &a [*a]", "an alias stands within what it names"),
        ("a: " + "[" * 5000 + "]" * 5000, "nested too deep"),
        ("- " * 5000 + "x", "nested too deep"),
        ("a: !!int x", "invalid literal"),
        ("a: !!python/name:os.system", "could not determine a constructor"),
        ('a: "\\ud800"', "invalid Unicode"),
        ("? [a]\n: 1", "unhashable"),
    ],
)
def test_what_is_no_document_is_refused(text, message):
    with pytest.raises(yaml.YAMLError, match=message):
        yaml_file.load(text)


def test_aliases_that_stand_for_millions_of_values_are_refused():
    lines = ["a: &a [x, x, x, x, x, x, x, x, x, x]"]
    lines += [
        f"{key}: &{key} [{', '.join(10 * [f'*{before}'])}]" for before, key in zip("abcdef", "bcdefg", strict=True)
    ]
    assert len(yaml_file.load("\n".join(lines[:3]))["c"]) == 10
    with pytest.raises(yaml.YAMLError, match="aliases stand for more than 1000000 values"):
        yaml_file.load("\n".join(lines))


def test_keys_that_are_merged_in_may_be_stated_anew():
    text = "w: &w {a: 1, b: 2}\nx: &x {<<: *w, a: 3}\ny: {<<: *x, b: 4}\nz: {<<: *x}\n"
    assert yaml_file.load(text) == {
        "w": {"a": 1, "b": 2},
        "x": {"a": 3, "b": 2},
        "y": {"a": 3, "b": 4},
        "z": {"a": 3, "b": 2},
    }


@pytest.mark.parametrize("path", sorted(ROOT.glob("**/config/*.yaml")) + [ROOT / "CITATION.cff"], ids=str)
def test_both_versions_of_yaml_read_the_same_in_the_shipped_documents(path):
    text = path.read_text(encoding="utf-8")
    assert yaml_file.load(text) == yaml.safe_load(text)
