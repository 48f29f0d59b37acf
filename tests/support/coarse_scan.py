"""A coarse first scan of the fits to records, for speed."""

from contextlib import contextmanager

import pytest

from rockdamp.laboratory import record_fit


@contextmanager
def coarse_scan():
    ratios, strengths, restitutions = record_fit.SCAN_VALUES
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(record_fit, "SCAN_VALUES", (ratios, strengths[::2], restitutions))
        patch.setattr(record_fit, "SCAN_HALVINGS", 4)
        yield
