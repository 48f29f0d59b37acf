"""Files that are written whole or not at all, and texts that are read."""

import pytest

from rockdamp.errors import InputError
from rockdamp.storage.files import read_text, replace_file


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "result.txt"
    path.write_text("old", encoding="utf-8")
    return path


def test_file_stays_if_the_block_fails(path):
    with pytest.raises(RuntimeError), replace_file(path) as temporary:
        temporary.write_text("half", encoding="utf-8")
        raise RuntimeError
    assert path.read_text(encoding="utf-8") == "old"
    assert list(path.parent.iterdir()) == [path]


def test_file_is_replaced_at_the_end(path):
    with replace_file(path) as temporary:
        temporary.write_text("new", encoding="utf-8")
        assert path.read_text(encoding="utf-8") == "old"
    assert path.read_text(encoding="utf-8") == "new"
    assert list(path.parent.iterdir()) == [path]


def test_byte_order_mark_is_dropped(path):
    path.write_bytes("\ufeffé\n".encode())
    assert read_text(path) == "é\n"


def test_other_bytes_are_refused_with_their_line(path):
    path.write_bytes(b"a\ncaf\xe9")
    with pytest.raises(InputError, match="0xe9 on line 2"):
        read_text(path)
