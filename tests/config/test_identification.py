"""Priors that cannot be are refused when a run starts, not when the stage does."""

import pytest
from repository import ROOT

from rockdamp.config.between_keys import problems
from rockdamp.config.identification import ALLOWED
from rockdamp.config.merging import merged
from rockdamp.errors import InputError
from rockdamp.identification.prior import Prior


@pytest.fixture
def config():
    return merged([ROOT / "config/default.yaml"], {})


@pytest.mark.parametrize(
    ("section", "name", "ends", "told"),
    [
        ("prior", "plateau_ratio", (0.9, 0.4), "identification.prior.plateau_ratio.high is 0.4; it must be greater"),
        ("prior", "plateau_ratio", (0.4, 1.0), "identification.prior.plateau_ratio is 0.4 to 1.0; it must be between"),
        ("prior", "restitution", (0.6, 1.1), "is 0.6 to 1.1; it must be greater than 0 and at most 1"),
        ("prior", "damping_ratio", (-0.1, 0.2), "is -0.1 to 0.2; it must be at least 0"),
        ("prior", "sensor_correlation", (-1.0, 0.2), "is -1.0 to 0.2; it must be between -1 and 1"),
        ("prior", "order", (0.0, 8.0), "identification.prior.order.low is 0.0; it must be greater than 0 for loguni"),
        ("simulated", "sensor_deviation", (2e-4, 1e-4), "identification.simulated.sensor_deviation.high is 0.0001"),
        ("simulated", "pulse_peak", (-1.0, 9.0), "is -1.0 to 9.0; it must be greater than 0"),
    ],
)
def test_a_distribution_that_cannot_be_is_told_with_its_place(config, section, name, ends, told):
    entry = config["identification"][section][name]
    entry["low"], entry["high"] = ends
    assert any(told in str(problem) for problem in problems(config))
    if section == "prior":  # what the stage would refuse is refused before
        with pytest.raises(InputError):
            Prior.of(config["identification"]["prior"])


def test_the_shipped_priors_are_possible_and_every_interval_is_checked(config):
    assert not problems(config)
    intervals = {
        name
        for section in ("prior", "simulated")
        for name, entry in config["identification"][section].items()
        if isinstance(entry, dict)
    }
    assert intervals == set(ALLOWED)
