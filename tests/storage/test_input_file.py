"""Files that others wrote are read once and whole, never waited for, and text or refused."""

import hashlib
import os
import subprocess
import sys
import threading

import pytest
from command_line import run

from rockdamp.errors import InputError
from rockdamp.motions.records import read_record
from rockdamp.storage import dataset, input_file

CSV = b"elapsed_s,ground_acceleration_m_s2\n0,0\n0.1,1\n0.2,0\n"
NEITHER = "is neither a regular file nor a stream such as /dev/stdin; it must be a record"


def test_a_stream_is_read_to_its_end_though_it_comes_in_parts():
    receiver, sender = os.pipe()

    def send():
        with os.fdopen(sender, "wb", buffering=0) as pipe:
            for start in range(0, len(CSV), 7):
                pipe.write(CSV[start : start + 7])

    writer = threading.Thread(target=send)
    writer.start()
    try:
        record = read_record(f"/dev/fd/{receiver}")
    finally:
        writer.join()
        os.close(receiver)
    assert record.ground_acceleration.tolist() == [0, 1, 0]
    assert record.digest == hashlib.sha256(CSV).hexdigest()


RESPOND = "respond --thickness 0.3 --height 3 --preset new --damping-model CR --restitution 0.9".split()


def test_a_command_reads_a_pipe_once_and_its_digest_is_that_of_what_was_read(tmp_path):
    def options(record, output):
        return [*RESPOND, "--record", str(record), "--output", str(output)]

    content = "elapsed_s,ground_acceleration_m_s2\n" + "".join(f"{t / 100},{int(t % 7 == 3)}\n" for t in range(50))
    (tmp_path / "record.csv").write_text(content, encoding="utf-8")
    command = [sys.executable, "-m", "rockdamp", *options("/dev/stdin", tmp_path / "piped.nc")]
    subprocess.run(command, input=content, text=True, check=True, capture_output=True)
    assert run(*options(tmp_path / "record.csv", tmp_path / "read.nc")).exit_code == 0
    piped, read = (dataset.open(tmp_path / name).attrs["config"] for name in ("piped.nc", "read.nc"))
    assert piped == read


def test_a_named_pipe_and_a_device_are_refused_without_waiting(tmp_path):
    os.mkfifo(tmp_path / "motion.csv")
    for path in (tmp_path / "motion.csv", "/dev/zero", "/dev/null"):
        with pytest.raises(InputError) as caught:
            read_record(path)
        assert str(caught.value).startswith(f"{path}: {NEITHER}")


@pytest.mark.parametrize("path", ["nowhere.csv", "."])
def test_what_is_no_file_is_one_line(path):
    with pytest.raises(InputError) as caught:
        input_file.content(path, "a file")
    assert "\n" not in str(caught.value)


def test_a_file_that_would_fill_the_memory_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(input_file, "MOST_BYTES", 10)
    (tmp_path / "long.csv").write_bytes(CSV)
    with pytest.raises(InputError, match=r"long\.csv: has more than 10 bytes; it must be a record"):
        read_record(tmp_path / "long.csv")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("a".encode("utf-16"), "byte 0xff on line 1 is not text; it must be UTF-8"),
        (b"a\ncaf\xe9", "byte 0xe9 on line 2 is not text"),
        (b"PK\x03\x04\x14\x00", "a.csv: is a workbook or an archive; it must be text: save it as CSV"),
        (b"\xd0\xcf\x11\xe0\xa1", "is a workbook"),
        (b"\x1b[2J", "character 0x1b on line 1 is a control character"),
    ],
)
def test_what_is_no_text_says_where(content, message):
    with pytest.raises(InputError, match=message):
        input_file.text(content, "a.csv")


def test_text_has_one_kind_of_line_end_and_no_byte_order_mark():
    assert input_file.text(b"\xef\xbb\xbfa\r\nb\rc\n", "a.csv") == "a\nb\nc\n"
