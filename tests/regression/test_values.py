"""Values of the minimal and of the full build: no change of a result goes unseen.

`python tests/regression/test_values.py minimal results/minimal` writes those of the minimal build anew, and with
`full results` those of the full one.
"""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

STORED = Path(__file__).parent
DATASETS = {
    "minimal": "mechanism damping_force decay/amplitude match/amplitude match/cracked_stiffness equivalence"
    " response_lengths validation convergence amplitude measured_rocking earthquakes comparison order loss_law"
    " supports",
    "full": "match/amplitude match/cracked_stiffness equivalence comparison order loss_law supports",
}
# Outcomes near collapse may turn on another processor.
LOOSE = (
    "earthquakes",
    "comparison",
    "order",
    "loss_law",
    "supports",
    "convergence",
    "validation",
    "response_lengths",
)


def summarise(folder, datasets):
    """Return the mean absolute value of each variable of floats, by dataset and name."""
    values = {}
    for name in datasets.split():
        with xr.open_dataset(folder / f"{name}.nc") as dataset:
            for key, variable in sorted(dataset.data_vars.items()):
                if variable.dtype.kind != "f" or "uncertainty" in key:
                    continue
                finite = np.abs(variable.values[np.isfinite(variable.values)])
                if finite.size:
                    values[f"{name} {key}"] = float(f"{finite.mean():.9g}")
    return values


def compare(build, folder):
    stored = json.loads((STORED / f"{build}.json").read_text(encoding="utf-8"))
    found = summarise(folder, DATASETS[build])
    assert found.keys() == stored.keys()
    for name, value in stored.items():
        assert found[name] == pytest.approx(value, rel=0.05 if name.startswith(LOOSE) else 1e-4), (
            name
        )


def test_the_minimal_build_has_its_values(minimal):
    compare("minimal", minimal)


def test_the_full_build_has_its_values():
    folder = STORED.parents[1] / "results"
    if not (folder / "report.html").exists():
        pytest.skip("no full build")
    compare("full", folder)


if __name__ == "__main__":
    build, folder = sys.argv[1:]
    text = json.dumps(summarise(Path(folder), DATASETS[build]), indent=0)
    (STORED / f"{build}.json").write_text(f"{text}\n", encoding="utf-8")
