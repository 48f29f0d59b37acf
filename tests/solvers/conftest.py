"""Tests of the solvers take any step, load and start on purpose."""

import pytest


@pytest.fixture(autouse=True)
def meant():
    yield
