"""Files that appear whole or not at all."""

import os
import stat

import pytest

from rockdamp.storage.atomic import replacing, tidy


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


@pytest.mark.parametrize("fault", [OSError, MemoryError, KeyboardInterrupt])
@pytest.mark.parametrize("call", ["open", "close", "lstat", "chmod", "fsync", "replace"])
def test_whichever_call_fails_the_old_file_stands_whole(tmp_path, monkeypatch, call, fault):
    def fail(*_, **__):
        raise fault

    path = tmp_path / "result.txt"
    path.write_text("old", encoding="utf-8")
    with monkeypatch.context() as patch, pytest.raises(fault):
        patch.setattr(os, call, fail)
        with replacing(path) as temporary:
            temporary.write_text("new", encoding="utf-8")
    assert path.read_text(encoding="utf-8") == "old"
    assert os.listdir(tmp_path) == ["result.txt"]


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o755])
def test_the_permissions_of_a_file_that_is_replaced_stay(tmp_path, mode):
    path = tmp_path / "result.txt"
    path.touch()
    path.chmod(mode)
    with replacing(path) as temporary:
        temporary.write_text("new", encoding="utf-8")
    assert stat.S_IMODE(path.stat().st_mode) == mode


def test_a_link_is_replaced_and_what_it_points_to_stays(tmp_path):
    (tmp_path / "source").write_text("mine", encoding="utf-8")
    (tmp_path / "result.txt").symlink_to(tmp_path / "source")
    with replacing(tmp_path / "result.txt") as temporary:
        temporary.write_text("new", encoding="utf-8")
    assert (tmp_path / "source").read_text(encoding="utf-8") == "mine"
    assert not (tmp_path / "result.txt").is_symlink()


def test_file_and_folder_are_on_the_disk_before_and_after_the_file_takes_its_place(tmp_path, monkeypatch):
    path, seen, real = tmp_path / "result.txt", [], os.fsync

    def fsync(descriptor):
        kind = "folder" if stat.S_ISDIR(os.fstat(descriptor).st_mode) else "file"
        seen.append((kind, path.exists()))
        real(descriptor)

    monkeypatch.setattr(os, "fsync", fsync)
    with replacing(path) as temporary:
        temporary.write_text("new", encoding="utf-8")
    assert seen == [("file", False), ("folder", True)]


def test_what_killed_processes_left_goes_away_and_nothing_else(tmp_path):
    with pytest.raises(KeyboardInterrupt), replacing(tmp_path / "result.txt") as temporary:
        left = temporary.name
        raise KeyboardInterrupt
    kept = ["result.txt", ".own.part", "own.0123456789abcdef.part", ".own.0123456789abcdef", "further"]
    for name in kept:
        (tmp_path / name).touch()
    (tmp_path / left).touch()
    (tmp_path / "further").unlink()
    (tmp_path / "further").mkdir()
    (tmp_path / "further" / left).touch()
    tidy(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(kept)
    assert (tmp_path / "further" / left).exists()
