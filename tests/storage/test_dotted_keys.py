"""Dotted keys: from text to a path and back, and the value that stands there."""

import pytest

from rockdamp.storage.dotted_keys import dotted, path_of, stated

WHOLE = {"a": {"b": [1, {"c": 2}]}, "d": "text"}


@pytest.mark.parametrize(("key", "path"), [("d", ("d",)), ("a.b[1].c", ("a", "b", 1, "c")), ("", ())])
def test_a_key_names_a_path_and_a_path_a_key(key, path):
    assert path_of(key) == path and dotted(path) == key


def test_a_value_is_read_by_its_key():
    assert stated(WHOLE, "a.b[1].c") == 2 and stated(WHOLE, ("a", "b", 0)) == 1 and stated(WHOLE, "") is WHOLE


@pytest.mark.parametrize("key", ["x", "a.x", "a.b[2]", "a.b.c", "d.x", "d[0]", "a[0]"])
def test_a_key_that_is_not_there_is_an_error(key):
    with pytest.raises(LookupError):
        stated(WHOLE, key)
