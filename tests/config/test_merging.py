"""The config from its files: as Snakemake merges them, by YAML 1.2, and where Snakemake would read something else."""

import pytest
from repository import ROOT
from rockdamp.config.merging import merged, refuse_other_readings, refuse_unreadable
from snakemake.common.configfile import load_configfile
from snakemake.utils import update_config

from rockdamp.errors import InputError
from rockdamp.storage import yaml_file

FILES = [ROOT / "config/default.yaml", *sorted(ROOT.glob("examples/*.yaml")), ROOT / "config/minimal.yaml"]
STATED = {"solver": {"step": 0.003}, "results": "elsewhere", "wall": 3, "records": {"a": {"b": 1}}}


def test_files_and_the_command_line_are_merged_as_snakemake_does():
    expected = {}
    for file in FILES:
        update_config(expected, yaml_file.load(file.read_text(encoding="utf-8")))
    update_config(expected, STATED)
    assert merged(FILES, STATED) == expected
    assert list(merged(FILES, STATED)) == list(expected)  # the report shows them in order


# --- what Snakemake would stumble over, or read otherwise -----------------------------------------------------------


def refusal(*arguments):
    """The one line that ends the program."""
    with pytest.raises(SystemExit) as caught:
        refuse_unreadable(arguments)
    said = str(caught.value)
    assert said.startswith("Error: ") and "\n" not in said
    return said


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("wall: {width: 1}\nwall: {width: 2}\n", 'bad.yaml, line 2: found duplicate key "wall"'),
        ("- wall\n", "is not a mapping of keys to values; a config must be one"),
        ("results: 2020-13-45\n", "month must be in 1..12; it must be YAML"),
        (b"results: caf\xe9\n", "byte 0xe9 on line 1 is not text; it must be UTF-8"),
    ],
)
@pytest.mark.parametrize("option", ["--configfile", "--configfiles"])
def test_what_is_no_config_is_one_line_with_its_file(tmp_path, content, message, option):
    good, bad = tmp_path / "good.yaml", tmp_path / "bad.yaml"
    good.write_text("results: results/mine\n", encoding="utf-8")
    bad.write_bytes(content if isinstance(content, bytes) else content.encode())
    said = refusal("-c2", "fig1", option, str(good), str(bad), "--dry-run")
    assert f"{bad}" in said and message in said
    with pytest.raises(InputError) as caught:
        merged([bad], {})
    assert f"Error: {caught.value}" == said


def test_a_target_that_the_option_took_for_a_file_is_said_to_be_one():
    said = refusal("--configfile", str(FILES[0]), "fig1")
    assert "fig1: there is no such file; it must be YAML; --configfile takes every name that follows it" in said
    said = refusal("--configfile", str(FILES[0]), str(ROOT / "README.md"))  # a target may be a file that is there
    assert said.endswith("it must be YAML; --configfile takes every name that follows it: name targets before it")


def test_what_can_be_read_is_let_through(tmp_path):
    refuse_unreadable(["-c2", "fig1", "--config", "results=a=b", "--configfile", str(FILES[0])])
    refuse_unreadable(["-c2", "fig1", "--", "--configfile"])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a: 1:30", "line 1: a is '1:30' in YAML 1.2, and 90 in YAML 1.1"),
        ("b: {a: 0o10}", "line 1: b.a is 8 in YAML 1.2, and '0o10' in YAML 1.1"),
        ("b: [1,\n  1e-3]", "line 2: b[1] is 0.001 in YAML 1.2, and '1e-3' in YAML 1.1"),
        ("a: yes", "line 1: a is 'yes' in YAML 1.2, and True in YAML 1.1"),
        ("a: 010", "line 1: a is 10 in YAML 1.2, and 8 in YAML 1.1"),
        ("on: 1", "is {'on': 1} in YAML 1.2, and {True: 1} in YAML 1.1"),
    ],
)
def test_what_both_versions_of_yaml_read_otherwise_is_refused(tmp_path, text, said):
    path = tmp_path / "own.yaml"
    path.write_text(text + "\n", encoding="utf-8")
    with pytest.raises(InputError) as caught:
        refuse_other_readings(load_configfile(path), [path], {})
    assert said in str(caught.value) and "\n" not in str(caught.value)


def test_what_both_read_alike_is_let_through():
    config = {}
    for file in FILES:
        update_config(config, load_configfile(file))
    update_config(config, STATED)
    refuse_other_readings(config, FILES, STATED)
