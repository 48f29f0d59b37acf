"""The wheel: every file that the package reads, and its metadata."""

import subprocess
import sys
import zipfile
from email import message_from_bytes

import pytest
from repository import ROOT


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The contents of the files of the wheel, by name."""
    folder = tmp_path_factory.mktemp("wheel")
    options = ["--quiet", "--no-index", "--no-deps", "--no-build-isolation"]
    command = [sys.executable, "-m", "pip", "wheel", *options, "--wheel-dir", folder, ROOT]
    subprocess.run(command, check=True, capture_output=True)
    (path,) = folder.glob("rockdamp-*.whl")
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_wheel_holds_the_package_and_nothing_else(wheel):
    source = ROOT / "src"
    files = {str(path.relative_to(source)) for path in source.rglob("*") if path.is_file()}
    packed = {name for name in wheel if ".dist-info/" not in name}
    assert packed == {name for name in files if "__pycache__" not in name}


@pytest.mark.parametrize(
    "name", ["py.typed", "storage/glossary.yaml", "report/report.html.j2", "figures/paper.mplstyle"]
)
def test_wheel_holds_data_files(wheel, name):
    assert f"rockdamp/{name}" in wheel


def test_metadata_has_readme_and_classifiers(wheel):
    (name,) = [name for name in wheel if name.endswith(".dist-info/METADATA")]
    metadata = message_from_bytes(wheel[name])
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert metadata["Description-Content-Type"] == "text/markdown"
    assert metadata.get_payload(decode=True).decode().strip() == readme.strip()
    assert "Programming Language :: Python :: 3.13" in metadata.get_all("Classifier")
    assert metadata["Requires-Python"] == "<3.14,>=3.11"
