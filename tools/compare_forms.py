"""Compare ECD of order m with its form without the denominator, whose damping ratio is the inverse of an integral.

`.venv/bin/python tools/compare_forms.py`, after `make`, runs the form that the package does not have in the histories
of results/earthquakes/orders-*.nc, under pulses and in free decay. In some minutes it writes tools/forms.csv, of which
`measured_tables.py` makes the tables of docs/theory.md, section 8.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import xarray as xr
from scipy.integrate import quad
from scipy.optimize import brentq

from rockdamp.config import Config
from rockdamp.config.files import merged
from rockdamp.histories.loads import CELLS, under_pulses, under_records
from rockdamp.laboratory.sections import LaboratoryConfig
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.damping.ecd import EnergyConsistent, critical_damping_ratio, normalisation
from rockdamp.motions import catalogue
from rockdamp.progress import track
from rockdamp.statistics.against_restitution import HISTORIES, bootstrapped, of_pairs, root_mean_square
from rockdamp.statistics.fragility import interval, resample
from rockdamp.storage import dataset
from rockdamp.studies.damper_order import measured
from rockdamp.studies.earthquakes.orders import Sums, judge
from rockdamp.vocabulary import DECISIVE_CHANGE

ROOT = Path(__file__).resolve().parents[1]
FILE = Path(__file__).with_name("forms.csv")
FORMS = ("with", "without")  # the denominator
ORDERS, RESTITUTIONS = np.array([1.0, 2.0, 4.0, 8.0, 16.0, 32.0]), np.array([0.75, 0.80, 0.85, 0.90, 0.95])
COARSE, CYCLES = 0.1, 3  # w1 h of the step whose error is compared, over so many periods of the first branch


def undivided(z: Any, f: Any, double_v: Any, v: Any, parameters: Any) -> Any:
    """Return C = kappa w (T/(T+V))^m."""
    double_t = v * v
    return parameters[0] * f / np.sqrt(double_v) * (double_t / (double_t + double_v)) ** parameters[1]


class Undivided(EnergyConsistent):
    """ECD of order m without the denominator."""

    formula = property(lambda self: undivided)


def size_without(e: float, order: float) -> float:
    """Return its kappa: that of which the integral of docs/theory.md, section 8, is -ln e."""

    def loss(kappa: float) -> float:
        def rate(phase: float) -> float:
            cos = math.cos(phase)
            return kappa * cos ** (2 * order + 2) / (1 - (kappa * cos ** (2 * order + 1) * math.sin(phase)) ** 2)

        return 2 * quad(rate, 0, math.pi / 2, epsabs=1e-13, limit=200)[0]

    most = 2 * float(critical_damping_ratio(order) * normalisation(order))
    return float(brentq(lambda kappa: loss(kappa) + math.log(e), 0.0, 0.9 * most, xtol=1e-14))


def forms(order: float) -> dict[str, Damping]:
    """Return both forms at each e."""
    size = np.array([size_without(e, order) for e in RESTITUTIONS])
    without = Undivided("ECD", size / (2 * float(normalisation(order))), order=order)
    return dict(zip(FORMS, (Damping.of_restitution(RESTITUTIONS, order=order), without), strict=True))


def in_free_decay(config: Config, order: float) -> dict[str, Any]:
    """Return errors of a decay of the paper's curve, and of a peak on its first branch by a coarse step."""
    at, first = np.ones_like(RESTITUTIONS), float(config.curve.initial_frequency)
    solver, dampings = config.solver, forms(order).values()
    both: Any = SimpleNamespace(restitution=RESTITUTIONS, each=lambda run: list(map(run, dampings)))
    release, low = config.release_amplitude * at, config.curve.yield_displacement_ratio / 2 * at
    length = {"response_length": config.matching.response_length, "step": solver.step}
    short = {"response_length": 2 * np.pi * CYCLES / first, "step": COARSE / first}
    whole = measured(config.curve, release, both, scheme=solver.scheme, **length)
    coarse = measured(config.curve, low, both, scheme=solver.scheme, **short)
    found = {"rms_error": whole["rms_error"], "duration_error": whole["duration_error"], "step": coarse["peak_error"]}
    return found | {"damping_ratio": np.stack([damping.damping_ratio for damping in dampings])}


def in_one_half_cycle(order: float) -> dict[str, Any]:
    """Return the largest force of a spring of stiffness 1 from y = 1, and the largest slope by y, over the phase."""
    phase = np.linspace(-np.pi / 2, np.pi / 2, 40001)
    cos, sin = np.cos(phase), np.sin(phase)
    force, slope = np.empty((2, *RESTITUTIONS.shape)), np.empty((2, *RESTITUTIONS.shape))
    for row, column in np.ndindex(force.shape):
        e = float(RESTITUTIONS[column])
        size = size_without(e, order) if row else -2 * math.log(e) / math.pi * float(normalisation(order))
        d = size * cos ** (2 * order)
        d = d if row else d / (1 - d * sin * cos)
        loss = d * cos**2 / (1 + d * sin * cos) * (phase[1] - phase[0])
        force[row, column] = np.max(d * cos * np.exp(-np.cumsum(loss)))
        slope[row, column] = np.max(np.abs(d * cos * sin + np.gradient(d * cos, phase) * cos))
    return {"force": force, "slope": slope}


def under_pulse(config: Config, order: float) -> dict[str, Any]:
    """Return the error of the peaks against restitution, under the pulses of results/damper_order.nc."""
    asked, dampings = config.damper_order.pulses, {"CR": Damping.cr(RESTITUTIONS), **forms(order)}
    steps = {"step": asked.step, "tail": asked.tail}
    ended = under_pulses(config.curve, dampings, asked.frequency, asked.load, dims=["restitution"], **steps)
    peak = ended["peak"].where(ended["collapsed"] == 0)
    ratio = peak.sel(damping_model=list(FORMS)) / peak.sel(damping_model="CR", drop=True)
    return {"pulse_error": of_pairs(ratio, CELLS)["log_error"].transpose("damping_model", "restitution").values}


def histories(config: Config, results: Path) -> xr.Dataset:
    """Return the stored histories of the orders, with ``peak`` and ``collapsed`` of both forms."""
    chunks = [dataset.open(path) for path in sorted((results / "earthquakes").glob("orders-*.nc"))]
    stored = xr.concat(chunks, "record", join="exact").sel(order=ORDERS, restitution=RESTITUTIONS)
    quakes = config.earthquakes
    walls = {named.name: (named.wall, named.curve) for named in quakes.walls}
    motions = map(catalogue.read, track(catalogue.listing(config.records), "records"))
    dampings = {f"{order:g}": forms(order)["without"] for order in ORDERS.tolist()}
    step = {"step": 2 * quakes.orders.step, "halvings": 1, "tail": quakes.tail}
    run = under_records(motions, walls, dampings, quakes.velocity_ratio, dims=["restitution"], **step)
    run = run.rename(damping_model="order").assign_coords(order=ORDERS, restitution=RESTITUTIONS)
    other = stored.assign({name: run[name].transpose(*stored[name].dims) for name in ("peak", "collapsed")})
    return xr.concat([stored, other], "form", join="exact", data_vars="all").assign_coords(form=list(FORMS))


def under_earthquakes(config: Config, both: xr.Dataset) -> xr.Dataset:
    """Return the errors of the peaks, also by band, the false outcomes, and whether an order is enough."""
    bands, bootstrap = config.comparison.bands, config.comparison.bootstrap
    edges = [(0.0, np.inf), *zip(bands[:-1].tolist(), bands[1:].tolist(), strict=True)]
    weights = resample(both["station"].values, bootstrap.replicates, bootstrap.seed)
    parts = []
    for form in FORMS:
        one = both.sel(form=form, drop=True).transpose(*HISTORIES, "restitution", "variation", "order")
        found = bootstrapped(one.drop_dims("variation"), weights, edges)
        whole = found.isel(band=0)[["log_error", "median_ratio", "false_safe_rate", "false_collapse_rate"]]
        by_band = {f"{low:g} to {high:g}": found["log_error"].isel(band=i) for i, (low, high) in enumerate(edges) if i}
        enough = judge(Sums.from_histories(one, DECISIVE_CHANGE), weights)[2][0]
        parts.append(whole.assign(by_band).assign(verdict=(("restitution", "order"), enough)))
    return xr.concat(parts, "form").merge(_difference(both, weights)).assign_coords(form=list(FORMS))


def _difference(both: xr.Dataset, weights: Any) -> xr.Dataset:
    """Return the interval of the error with the denominator less that without, over the same histories."""
    stand = ((both["collapsed"] == 0) & (both["reference_collapsed"] == 0)).all("form")
    squares = (np.log(both["peak"] / both["reference_peak"]) ** 2).where(stand, 0.0).transpose("form", ...)
    within, order = [name for name in HISTORIES if name != "record"], ("record", "restitution", "order")
    first, second, count = [np.tensordot(weights, sums.sum(within).transpose(*order), 1) for sums in (*squares, stand)]
    bounds = interval(root_mean_square(first, count) - root_mean_square(second, count))
    return xr.Dataset({"more_low": (order[1:], bounds[..., 0]), "more_high": (order[1:], bounds[..., 1])})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--results", type=Path, default=ROOT / "results")
    parser.add_argument("--config", type=Path, default=ROOT / "config/default.yaml", help="that of the results")
    given = parser.parse_args()
    config = LaboratoryConfig.model_validate(merged([given.config], {}))
    alone = [
        {**in_free_decay(config, order), **in_one_half_cycle(order), **under_pulse(config, order)}
        for order in track(ORDERS.tolist(), "decays and pulses")
    ]
    found = under_earthquakes(config, histories(config, given.results))
    found = found.assign_coords(order=ORDERS, restitution=RESTITUTIONS)
    found = found.assign({name: (("order", "form", "restitution"), [one[name] for one in alone]) for name in alone[0]})
    table = found.to_dataframe(dim_order=["restitution", "order", "form"])
    table.to_csv(FILE, float_format="%.4g", lineterminator="\n")


if __name__ == "__main__":
    main()
