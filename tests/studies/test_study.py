"""The walls of a study: one parameter varies, and the others are those of the config."""

import pytest
from configs import configured, merge_files

from rockdamp.constants import STUDIES
from rockdamp.studies.study import make_study


@pytest.fixture(params=STUDIES)
def study(request):
    return make_study(request.param, configured())


def test_study_has_the_values_of_the_config(study):
    values = merge_files()["studies"][study.name]
    assert study.values.tolist() == values
    assert study.curve.shape == (len(values),)


def test_study_varies_its_parameter_only(study):
    varies_a1 = study.name == "cracked_stiffness"
    varies_release = study.name == "amplitude"
    for index, value in enumerate(study.values):
        a1 = float(study.curve.yield_displacement_ratio[index])
        b1 = float(study.curve.strength_ratio[index])
        assert a1 == (value if varies_a1 else 0.04), value
        assert b1 == (0.75 if a1 >= 0.15 else 0.85), value
        assert study.release_amplitude[index] == (value if varies_release else 0.5), value


def test_frequency_parameter_is_that_of_each_wall(study):
    assert study.varies_wall == (study.name in ("slenderness", "overburden"))
    for index, value in enumerate(study.values):
        change = {"wall": {study.parameter: value}} if study.varies_wall else {}
        wall = configured(change).wall.make()
        assert study.frequency_parameter[index] == wall.frequency_parameter, value
