"""The config from its files: as Snakemake merges them, by YAML 1.2."""

import pytest
from repository import ROOT
from snakemake.utils import update_config

from rockdamp.config.merging import merged
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


def test_what_is_merged_leaves_its_sources_alone():
    stated = {"wall": {"thickness": 1.0}}
    merged([FILES[0]], stated)["wall"]["width"] = 5
    assert stated == {"wall": {"thickness": 1.0}}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("wall: {width: 1}\nwall: {width: 2}\n", "line 2: key 'wall' stands there more than once, first on line 1"),
        ('{"wall": 1, "wall": 2}', "line 1: key 'wall' stands there more than once"),
        ("- wall\n", "is not a mapping of keys to values; a config must be one"),
        ("wall:\n\twidth: 1\n", "line 2: found character that cannot start any token"),
        ("a: [\n", "line 2: did not find expected node content"),
        (b"\xff\xfea\x00", "byte 0xff on line 1 is not text; it must be UTF-8"),
        (b"results: caf\xe9\n", "byte 0xe9 on line 1 is not text; it must be UTF-8"),
        (b"\x00\x01", "character 0x00 on line 1 is a control character"),
    ],
)
def test_what_is_no_config_is_one_line_with_its_file(tmp_path, content, message):
    path = tmp_path / "config.yaml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(InputError) as caught:
        merged([path], {})
    assert str(caught.value).startswith(str(path)) and message in str(caught.value)
    assert "\n" not in str(caught.value)
