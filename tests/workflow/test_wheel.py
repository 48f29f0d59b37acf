"""The wheel holds every file that the package reads."""

import subprocess
import sys
import zipfile

from repository import ROOT


def test_the_wheel_holds_the_package_and_nothing_else(tmp_path):
    pip = [
        sys.executable,
        "-m",
        "pip",
        "wheel",
        "--quiet",
        "--no-index",
        "--no-deps",
        "--no-build-isolation",
    ]
    subprocess.run([*pip, "--wheel-dir", tmp_path, ROOT], check=True, capture_output=True)
    (wheel,) = tmp_path.glob("rockdamp-*.whl")
    source = ROOT / "src"
    files = {str(path.relative_to(source)) for path in source.rglob("*") if path.is_file()}
    found = {name for name in zipfile.ZipFile(wheel).namelist() if name.startswith("rockdamp/")}
    assert found == {name for name in files if "__pycache__" not in name}
    assert {
        "rockdamp/py.typed",
        "rockdamp/storage/glossary.yaml",
        "rockdamp/report/report.html.j2",
    } <= found
