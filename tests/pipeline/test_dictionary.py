"""The data dictionary: of the datasets that are there, with what uses them."""

import numpy as np
import xarray as xr

from rockdamp.pipeline import verification
from rockdamp.storage import dataset


def test_each_variable_has_its_dimensions_unit_and_meaning_and_each_dataset_what_uses_it(tmp_path):
    dims = ("slenderness", "restitution", "tau")
    coords = {"slenderness": [12.0], "restitution": [0.9], "tau": [0.0, 1.0]}
    values = {"displacement": (dims, np.ones((1, 1, 2))), "velocity": (dims, np.zeros((1, 1, 2)))}
    decay = xr.Dataset(values | {"impacts": (dims[:2], [[3]]), "frequency_parameter": ("slenderness", [4.0])}, coords)
    dataset.write(decay, tmp_path / "decay/amplitude.nc", "decay", config={}, code_version="0")
    verification.write_dictionary(tmp_path)
    text = (tmp_path / "dictionary.md").read_text(encoding="utf-8")
    assert "| `velocity` | `slenderness`, `restitution`, `tau` | 1 | velocity over instability displacement and" in text
    assert (
        "| `frequency_parameter` | `slenderness` | rad s-1 | frequency parameter of the wall | p = sqrt(K0/m_eff) |"
        in text
    )
    assert "## `decay/{study}.nc`\n\nFree decays under a coefficient of restitution. Used by match, " in text
    assert "match.nc" not in text  # it is not there
    assert "`rockdamp respond --output` writes such a file." in text


def test_what_uses_a_dataset_is_computed():
    assert {"accuracy", "claims", "fig3", "fig4", "report"} <= set(verification.used_by("damping_force"))
    assert {"match", "response_lengths", "accuracy"} <= set(verification.used_by("decay"))
    assert not {"fig6", "damping_force", "report"} & set(verification.used_by("decay"))
    assert verification.used_by("earthquake_records") == ["earthquakes"]
