"""Files that appear whole or not at all."""

import errno
import os

import pytest

from rockdamp.storage.atomic import replacing


def test_a_file_takes_its_place_at_the_end(tmp_path):
    path = tmp_path / "result.txt"
    path.write_text("old", encoding="utf-8")
    with replacing(path) as temporary:
        temporary.write_text("new", encoding="utf-8")
        assert path.read_text(encoding="utf-8") == "old"
    assert path.read_text(encoding="utf-8") == "new"
    assert os.listdir(tmp_path) == ["result.txt"]


def test_after_a_failure_the_old_file_stands_and_nothing_is_left_over(tmp_path):
    path = tmp_path / "result.txt"
    path.write_text("old", encoding="utf-8")
    with pytest.raises(RuntimeError, match="half way"), replacing(path) as temporary:
        temporary.write_text("ne", encoding="utf-8")
        raise RuntimeError("half way")
    assert path.read_text(encoding="utf-8") == "old"
    assert os.listdir(tmp_path) == ["result.txt"]


def test_a_full_disk_is_named_with_the_file(tmp_path):
    path = tmp_path / "result.txt"
    with pytest.raises(OSError, match=r"No space left on device: '.*result\.txt'"), replacing(path):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert os.listdir(tmp_path) == []
