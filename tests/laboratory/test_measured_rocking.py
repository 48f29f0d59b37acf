"""The stage on a part of the trials: its dataset is whole, and its numbers agree with each other."""

from itertools import combinations

import numpy as np
import pytest
from configs import changed, configured
from repository import ROOT

from rockdamp.constants import BLOCK_RESTITUTION_DEVIATION
from rockdamp.laboratory import measured_rocking as stage
from rockdamp.storage import dataset

FILE = ROOT / "data/measured/limestone-free-rocking.csv"


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Four blocks, three trials of each."""
    rows = FILE.read_text(encoding="utf-8").splitlines(keepends=True)
    kept = [row for row in rows if not row[0].isdigit() or few(*map(int, row.split(",")[:2]))]
    path = tmp_path_factory.mktemp("trials") / "few.csv"
    path.write_text("".join(kept), encoding="utf-8")
    section = {"trials": str(path), "bootstrap": {"replicates": 10, "seed": 1}, "simulated": {"draws": 1, "seed": 1}}
    config = configured({"measured_rocking": section}, minimal=True)
    return stage.measured_rocking(changed(config, {"measured_rocking.bootstrap.replicates": 3}))


def few(group, trial):
    return group % 3 == 1 and trial <= 3


def test_the_dataset_is_what_the_glossary_says(found):
    dataset.check(found, "measured_rocking")
    assert all(np.isfinite(variable).all() for variable in found.data_vars.values())


def test_the_same_case_has_the_same_likelihood_wherever_it_stands(found):
    likelihood = found["log_likelihood"].isel(impacts_used=0)
    for model in ("CDC", "CDR", "SDR"):
        expected = pytest.approx(float(likelihood.sel(damping_model=model)), abs=0.1)
        assert float(found["log_likelihood_by_curve"].sel(viscous_model=model)[0]) == expected
        assert float(found["log_likelihood_by_release"].sel(viscous_model=model)[0]) == expected


def test_a_free_loss_at_each_impact_is_at_least_as_likely_as_any_law(found):
    assert float(found["free_log_likelihood"]) > float(found["log_likelihood"].max()) - 0.1
    np.testing.assert_allclose(np.log(found["loss_by_impact"]).mean(), 0.0, atol=1e-9)


def test_every_choice_of_geometries_is_held_out_and_every_simulated_set_chosen_once(found):
    assert found.sizes["choice"] == len(list(combinations(range(4), 1)))
    assert (found["simulated_choices"].sum("chosen") == 1).all()


def test_the_spread_that_the_package_ships_is_that_of_the_built_trials():
    try:
        study = dataset.read(ROOT / "results/measured_rocking.nc")
    except FileNotFoundError:
        pytest.skip("the full results are not built")
    whole = np.hypot(float(study["deviation_within"]), float(study["deviation_between"]))
    assert whole == pytest.approx(BLOCK_RESTITUTION_DEVIATION, abs=0.001)
    assert round(float(study["restitution_over_housner_mean"]), 2) == 0.99
