"""Files that are written whole or not at all, and texts that are read."""

import pytest

from rockdamp.errors import InputError
from rockdamp.storage.files import read_text, replace_file


def test_a_file_is_replaced_at_the_end_and_stays_where_the_block_fails(tmp_path):
    path = tmp_path / "result.txt"
    path.write_text("old", encoding="utf-8")
    with pytest.raises(RuntimeError), replace_file(path) as temporary:
        temporary.write_text("half", encoding="utf-8")
        raise RuntimeError
    assert path.read_text(encoding="utf-8") == "old" and list(tmp_path.iterdir()) == [path]
    with replace_file(path) as temporary:
        temporary.write_text("new", encoding="utf-8")
        assert path.read_text(encoding="utf-8") == "old"
    assert path.read_text(encoding="utf-8") == "new" and list(tmp_path.iterdir()) == [path]


def test_text_is_utf_8_with_or_without_a_mark(tmp_path):
    path = tmp_path / "text"
    path.write_bytes("\ufeffé\n".encode())
    assert read_text(path) == "é\n"
    path.write_bytes(b"a\ncaf\xe9")
    with pytest.raises(InputError, match="0xe9 on line 2"):
        read_text(path)
