"""YAML: what users write, by YAML 1.2, and the package's documents, which both versions of YAML read alike."""

import pytest
from repository import ROOT

from rockdamp.errors import InputError
from rockdamp.storage import yaml_file
from rockdamp.storage.yaml_file import dotted, get, path_of


@pytest.mark.parametrize(
    ("text", "value"),
    [("010", 10), ("1e3", 1000.0), ("1:30", "1:30"), ("yes", "yes"), ("true", True), ("~", None), ("'010'", "010")],
)
def test_values_of_users_are_those_of_yaml_1_2(text, value, tmp_path):
    path = tmp_path / "own.yaml"
    path.write_text(f"a: {text}\n", encoding="utf-8")
    read = yaml_file.read(path)["a"]
    assert read == value and type(read) is type(value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: 1\nb: 2\na: 1\n", 'own.yaml, line 3: found duplicate key "a"'),
        ("a: !!int x", "own.yaml: "),
        ("a: !!python/name:os.system", "own.yaml, line 1: could not determine a constructor"),
        ("a: 0.8_5\n", "own.yaml, line 1: '0.8_5' is no number; text must stand in quotes"),
        ("wall:\n\twidth: 1\n", "own.yaml, line 2: found character"),
    ],
)
def test_what_is_no_document_is_refused_in_one_line(text, message, tmp_path):
    path = tmp_path / "own.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        yaml_file.read(path)
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_a_line_is_that_of_the_key_or_of_the_item(tmp_path):
    path = tmp_path / "own.yaml"
    path.write_text("# own\na:\n  b:\n  - 1\n  - {c: 2}\n", encoding="utf-8")
    lines = {
        (): None,
        ("a",): 2,
        ("a", "b"): 3,
        ("a", "b", 1): 5,
        ("a", "b", 1, "c"): 5,
        ("a", "c"): None,
        ("a", 0): None,
    }
    assert {key: yaml_file.line_of(path, key) for key in lines} == lines


DOCUMENTS = [
    ROOT / "CITATION.cff",
    *(path for top in ("config", "examples", "src") for path in ROOT.glob(f"{top}/**/*.yaml")),
]


@pytest.mark.parametrize("path", sorted(DOCUMENTS), ids=lambda path: str(path.relative_to(ROOT)))
def test_both_versions_of_yaml_read_the_same_in_the_shipped_documents(path):
    assert yaml_file.load(path.read_text(encoding="utf-8")) == yaml_file.read(path)


WHOLE = {"a": {"b": [1, {"c": 2}]}, "d": "text"}


@pytest.mark.parametrize(
    ("text", "key"),
    [("a: &a [*a]", "a[0]"), ("wall: &w {thickness: *w}", "wall.thickness"), ("a: {b: &b [1, {c: *b}]}", "a.b[1].c")],
)
def test_an_alias_of_what_it_stands_in_is_refused_by_its_key(text, key, tmp_path):
    path = tmp_path / "loop.yaml"
    path.write_text(f"{text}\n", encoding="utf-8")
    with pytest.raises(InputError) as caught:
        yaml_file.read(path)
    assert str(caught.value) == f"{path}: {key} is an alias of what it stands in; it must be a value"


def test_an_alias_of_another_value_is_that_value(tmp_path):
    path = tmp_path / "own.yaml"
    path.write_text("a: &a [1, 2]\nb: [*a, *a]\n", encoding="utf-8")
    assert yaml_file.read(path) == {"a": [1, 2], "b": [[1, 2], [1, 2]]}


@pytest.mark.parametrize(("key", "path"), [("d", ("d",)), ("a.b[1].c", ("a", "b", 1, "c")), ("", ())])
def test_a_key_names_a_path_and_a_path_a_key(key, path):
    assert path_of(key) == path and dotted(path) == key


def test_a_value_is_read_by_its_key():
    assert get(WHOLE, "a.b[1].c") == 2 and get(WHOLE, ("a", "b", 0)) == 1 and get(WHOLE, "") is WHOLE


@pytest.mark.parametrize("key", ["x", "a.x", "a.b[2]", "a.b.c", "d.x", "d[0]", "a[0]"])
def test_a_key_that_is_not_there_is_an_error(key):
    with pytest.raises(LookupError):
        get(WHOLE, key)
