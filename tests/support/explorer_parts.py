"""What the report's explorer is tested on: short decays of the solver at the closed form's damping ratios."""

from functools import cache

import report_content
import yaml
from repository import ROOT

from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.studies import explorer_decays
from rockdamp.vocabulary import VISCOUS_MODELS


@cache
def config():
    config = yaml.safe_load((ROOT / "config/default.yaml").read_text(encoding="utf-8"))
    return {**config, "explorer": {"length": 6, "spacing": 0.051}}


@cache
def matches():
    made = report_content.made_up("match", "release_amplitude")
    curve = TrilinearCurve(0.04, 0.85)
    for model in VISCOUS_MODELS:
        made["damping_ratio"].loc[{"damping_model": model}] = damping_ratio_energy(
            curve, model, made["restitution"].values, made["release_amplitude"].values[:, None]
        )
    return made


@cache
def stored():
    return explorer_decays.explorer(config(), matches())
