"""Tests of the solvers take any step, load and start on purpose."""

import pytest

from rockdamp.plausibility import as_meant


@pytest.fixture(autouse=True)
def meant():
    with as_meant():
        yield
