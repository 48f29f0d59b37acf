"""The config from its files: as Snakemake merges them, by YAML 1.2."""

import pytest
from repository import ROOT
from snakemake.cli import parse_config
from snakemake.utils import update_config

from rockdamp.config.files import merged, refuse_unreadable
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
    ("text", "value"),
    [("1e-3", 0.001), ("010", 10), ("0o10", 8), ("1:30", "1:30"), ("yes", "yes"), ("on", "on"), ("0,04", "0,04")],
)
def test_files_are_read_by_yaml_1_2(tmp_path, text, value):
    path = tmp_path / "own.yaml"
    path.write_text(f"a: {text}\n", encoding="utf-8")
    assert merged([path], {}) == {"a": value}


def test_values_of_the_command_line_are_what_they_are_in_a_file():
    """Snakemake leaves all that is nested as text, and null too."""
    said = ["earthquakes=null", "amplitude=", "restitution={start: 0.7, stop: 0.95, step: 5e-2}", "records=[a.csv, 2]"]
    found = merged([], parse_config([*said, "solver={scheme: paper}", "release_amplitude=0.4"]))
    assert found.pop("restitution") == {"start": 0.7, "stop": 0.95, "step": 0.05}
    assert found.pop("earthquakes") is None and found.pop("amplitude") is None
    assert found == {"records": ["a.csv", 2], "solver": {"scheme": "paper"}, "release_amplitude": 0.4}
