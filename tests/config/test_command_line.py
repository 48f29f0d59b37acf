"""What Snakemake is told on its command line: a file that it cannot read ends in one line, and values are YAML 1.2."""

import os

import pytest
from snakemake.common.configfile import load_configfile

from rockdamp.config.command_line import refuse_unreadable, values_of
from rockdamp.errors import InputError

DEEP = "[" * 5000 + "]" * 5000
BOMB = "x0: &x0 {a: 1}\n" + "".join(
    f"x{level}: &x{level} {{{', '.join(f'k{each}: *x{level - 1}' for each in range(9))}}}\n" for level in range(1, 25)
)


def refusal(*arguments):
    """The one line that ends the program."""
    with pytest.raises(SystemExit) as caught:
        refuse_unreadable(arguments, load_configfile)
    said = str(caught.value)
    assert said.startswith("Error: ") and "\n" not in said
    return said


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"\xff\xfea\x00", "byte 0xff on line 1 is not text; it must be UTF-8"),
        (b"# caf\xe9\n", "byte 0xe9 on line 1 is not text"),
        (b"results: \x00\x01\n", "character 0x00 on line 1 is a control character"),
        (DEEP.encode(), "it is nested too deep"),
        (f"a: {DEEP}\n".encode(), "it is nested too deep"),
        (BOMB.encode(), "its aliases stand for more than 1000000 values"),
        (b"a: [\n", "line 2: did not find expected node content"),
        (b"results: 2020-13-45\n", "Snakemake cannot read it (month must be in 1..12); put what is text in quotes"),
        (b"- results\n", "is not a mapping of keys to values"),
    ],
    ids=["utf-16", "latin-1", "binary", "deep JSON", "deep YAML", "aliases", "cut", "no date", "list"],
)
@pytest.mark.parametrize("option", ["--configfile", "--configfiles"])
def test_a_file_that_snakemake_would_stumble_over_is_told_in_one_line(tmp_path, content, message, option):
    good, bad = tmp_path / "good.yaml", tmp_path / "bad.yaml"
    good.write_text("results: results/mine\n", encoding="utf-8")
    bad.write_bytes(content)
    said = refusal("-c2", "fig1", option, str(good), str(bad), "--dry-run")
    assert f"{bad}" in said and message in said


def test_a_file_is_a_file(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    assert "pipe: is a pipe or a device; a config is read more than once" in refusal("--configfile", f"{tmp_path}/pipe")
    assert "is a directory; it must be YAML" in refusal("--configfile", str(tmp_path))
    assert "nowhere.yaml: there is no such file" in refusal("--configfile", "nowhere.yaml")


def test_what_can_be_read_is_not_told(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("results: results/mine\n", encoding="utf-8")
    refuse_unreadable(["-c2", "fig1", "--config", "results=a=b", "--configfile", str(path)], load_configfile)
    refuse_unreadable(["-c2", "fig1", "--", "--configfile"], load_configfile)


@pytest.mark.parametrize("entry", ["results", "=1", "1st=2", "ré sults=2", ""])
def test_a_value_without_a_key_is_told(entry):
    assert f"--config has {entry!r}; it must be KEY=VALUE" in refusal("--config", "results=x", entry)
    with pytest.raises(InputError):
        values_of([entry])


def test_values_are_those_of_yaml_1_2_and_not_of_python():
    numbers = {"release_amplitude=1_0": "1_0", "step=١": "١", "count=010": 10, "step=1e-3": 0.001, "step=1:30": "1:30"}
    for entry, value in numbers.items():
        (read,) = values_of([entry]).values()
        assert (type(read), read) == (type(value), value)
    assert values_of(["results=2020-13-45", "draw=true", "nothing="]) == {
        "results": "2020-13-45",
        "draw": True,
        "nothing": None,
    }


def test_nested_values_are_merged_and_have_numbers():
    assert values_of(["wall={thickness: 0.3, width: 1_0}", "wall={width: 2}"]) == {
        "wall": {"thickness": 0.3, "width": 2}
    }
    assert values_of(["results=[x"]) == {"results": "[x"}  # as Snakemake takes what is no YAML
