"""Which histories of the study are solved again, event by event; that they are solved right stands in test_blows."""

from types import SimpleNamespace

import made_up_earthquakes as made_up
import numpy as np
import pytest
import yaml
from repository import ROOT

from rockdamp.studies.earthquakes import event_driven_check

AT = ("record", "scale", "wall", "restitution", "damping_model", "damping_ratio_source")


@pytest.fixture(scope="module")
def natural():
    return made_up.natural()


@pytest.fixture
def chosen(natural, monkeypatch):
    """The histories that a seed draws, where solving one takes no time."""
    entries = [SimpleNamespace(name=name) for name in natural["record"].values.tolist()]
    monkeypatch.setattr(event_driven_check.catalogue, "listing", lambda _: entries)
    monkeypatch.setattr(event_driven_check.catalogue, "read", lambda entry: entry)
    monkeypatch.setattr(event_driven_check, "exact_peak", lambda case, *_: (0.5, False))
    config = yaml.safe_load((ROOT / "config/default.yaml").read_text(encoding="utf-8"))

    def draw(seed, **given):
        config["natural"]["check"] |= {"seed": seed, **given}
        found = event_driven_check.check(config, natural)
        return list(zip(*(found[name].values.tolist() for name in AT), strict=True)), found

    return draw


def test_a_seed_draws_the_same_histories_again_and_another_seed_draws_others(chosen):
    first, again, other = (chosen(seed)[0] for seed in (1, 1, 2))
    assert first == again
    assert len(set(first) & set(other)) < 0.5 * len(first)


def test_no_history_is_drawn_twice_and_none_that_was_not_run(chosen, natural):
    for seed in range(3):
        drawn, found = chosen(seed)
        assert len(set(drawn)) == len(drawn) == found.sizes["history"]
        assert (found["collapsed"] >= 0).all()
        for at, peak in zip(drawn, found["peak_displacement"].values, strict=True):
            assert float(natural["peak_displacement"].sel(dict(zip(AT, at, strict=True)))) == peak


def test_every_damper_wall_and_restitution_is_drawn_from(chosen):
    drawn = {at for seed in range(8) for at in chosen(seed)[0]}
    seen = [set(values) for values in zip(*drawn, strict=True)]
    assert seen[AT.index("damping_model")] == set(made_up.MODELS)
    assert seen[AT.index("wall")] == set(made_up.WALLS) and seen[AT.index("restitution")] == set(made_up.E.tolist())
    assert np.ptp([at[AT.index("scale")] for at in drawn]) == pytest.approx(np.ptp(made_up.SCALE))
