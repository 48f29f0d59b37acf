"""The stage of identification: the noise that is added to the records of a test series, and what it refuses."""

from dataclasses import replace

import numpy as np
import pytest
from configs import configured
from repository import ROOT

from rockdamp.errors import InputError
from rockdamp.laboratory.posterior import identification, noisier
from rockdamp.motions.records import read_record


def test_noise_is_added_until_it_is_the_multiple_asked_for():
    record = read_record(ROOT / "data/test_series/cr-half.csv")
    more = noisier(record, 3.0, np.random.RandomState(1))
    for name, before in (("ground_acceleration", 0.02), ("displacement", 1.5e-4)):
        added = getattr(more, name) - getattr(record, name)
        assert added.std() == pytest.approx(np.sqrt(8) * before, rel=0.1)
    assert noisier(record, 1.0, np.random.RandomState(1)) == record


def test_a_test_series_of_measured_records_is_refused():
    record = read_record(ROOT / "data/test_series/cr-half.csv")
    measured = replace(record, header={**record.header, "synthetic": "no"})
    with pytest.raises(InputError, match="identification.test_series: mine is not synthetic"):
        identification(configured(), {"mine": measured})
