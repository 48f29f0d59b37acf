"""Tables of docs/identification.md: how often intervals hold the truth, evidence, and random tests."""

from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from check_posterior import Z
from check_posterior import summary as summary_of_tests
from posterior_records import LEVELS, summary
from random_tests import NAMES
from table_text import percent, table

from rockdamp.laboratory.figures import compared
from rockdamp.text import number

Data = dict[str, xr.Dataset]

IDENTIFICATION = "identification"
RECORDS = Path(__file__).with_name("posterior-check.csv")  # of check_posterior.py --records
RANDOM_TESTS = Path(__file__).with_name("random-tests.csv")  # of check_posterior.py --tests
FREE_ROCKING = Path(__file__).with_name("free-rocking-check.csv")
LOSSES = Path(__file__).with_name("losses-check.csv")
SLIPS = Path(__file__).with_name("slips-check.csv")
PARAMETERS = {
    "yield_displacement_ratio": "a1",
    "strength_ratio": "b1",
    "restitution": "e",
    "sensor_deviation": "deviation of the sensor's noise",
    "sensor_correlation": "its correlation from sample to sample",
}


def coverage(_: Data) -> str:
    """How often intervals hold what made a simulated record, and the standard deviation of z: the stored check."""
    found = summary(pd.read_csv(RECORDS))
    drawn, identified = (int(found[name].iloc[0]) for name in ("records", "identified"))
    errors = [float(np.sqrt(level * (1 - level) / identified)) for level in LEVELS]
    held = [f"held_{level}" for level in LEVELS]
    away = abs(found[held].to_numpy() - LEVELS) / errors
    told = (
        f"Of {drawn} records {identified} were identified, and {drawn - identified} refused. "
        f"By chance a share differs from its level by {percent(errors[0])} and {percent(errors[1])} (standard errors), "
        f"and the deviation of z from 1 by {percent(1 / np.sqrt(2 * identified))}; "
        f"the share that is farthest off differs by {float(away.max()):.1f} of these."
    )
    head = ["parameter", "50 %", "90 %", "50 %, least squares", "90 %, least squares", "deviation of z"]
    rows = []
    for name, of in found.iterrows():
        shares = [of[f"{share}{kind}"] for kind in ("", "_by_least_squares") for share in held]
        shown = [percent(value) if np.isfinite(value) else "–" for value in shares]
        rows.append([PARAMETERS[str(name)], *shown, f"{of['deviation_of_z']:.2f}", number(of["p"], 2)])
    return f"{told}\n\n{table([*head, 'uniform ranks, p'], rows)}"


def support(data: Data) -> str:
    """Which damping models the evidence supports for the records of the test series, at each noise."""
    study = data[IDENTIFICATION]
    names = list(map(str, study["damping_model"].values))
    head = ["made by", "noise", "records", "maker most probable", *names]
    rows = []
    for maker in dict.fromkeys(study["record_made_by"].values.tolist()):
        for factor in study["noise_factor"].values:
            of = compared(study).sel(noise_factor=factor).isel(record=(study["record_made_by"] == maker).values)
            known = of.dropna("record")
            most = [names[index] for index in known.argmax("damping_model").values]
            rows.append(
                [maker, f"× {factor:g}", f"{known.sizes['record']} of {of.sizes['record']}"]
                + [str(most.count(maker)) if maker in names else "–"]
                + [f"{float(known.sel(damping_model=name).mean()):.2f}" if known.size else "–" for name in names]
            )
    missing = int(np.isnan(study["log_evidence"]).sum())
    told = f"Of {study['log_evidence'].size} evidences {missing} were not determined; their records are left out."
    return f"{table(head, rows)}\n\n{told}"


def random_tests(_: Data) -> str:
    """What the posterior says of random tests that the event-driven solver made, by how far the wall rocks."""
    rows = pd.read_csv(RANDOM_TESTS)
    bands = {"all": rows, "below half of u_ins": rows[rows["peak"] < 0.5], "beyond": rows[rows["peak"] >= 0.5]}
    found = [summary_of_tests(some) for some in bands.values()]
    lines = [["tests", *(f"{one['tests']:.0f}" for one in found)]]
    for ended, words in (("answered", "answered"), ("refused", "refused"), ("failed", "ended in a traceback")):
        lines.append([words, *(f"{one[ended]:.0f}" for one in found)])
    for name in NAMES:
        of, answered = PARAMETERS[name], [one["answered"] for one in found]
        z = [
            f"{one[f'deviation_of_z_{name}']:.2f} ± {np.sqrt(0.5 / n):.2f}"
            for one, n in zip(found, answered, strict=True)
        ]
        held = [
            f"{percent(one[f'held_{name}'])} ± {percent(np.sqrt(0.09 / n))}"
            for one, n in zip(found, answered, strict=True)
        ]
        lines.append([f"deviation of z of {of}", *z])
        lines.append([f"uniform ranks of {of}, p", *(number(one[f"p_{name}"], 2) for one in found)])
        lines.append([f"90 % intervals that hold {of}", *held])
    seconds = [f"{some['seconds'].median():.0f} s, {some['seconds'].max():.0f} s" for some in bands.values()]
    lines.append(["time of a processor, median and longest", *seconds])
    refused = rows.loc[rows["ended"] == "refused", "reason"]
    causes = {
        "the response to the accelerometer's noise decides": refused.str.contains("accelerometer's noise").sum(),
        "the rest before the motion is too short": refused.str.contains("samples at rest").sum(),
    }
    causes["another reason"] = len(refused) - sum(causes.values())
    why = "; ".join(f"{words}: {int(count)}" for words, count in causes.items())
    deviations = {PARAMETERS[name]: found[0][f"deviation_of_z_{name}"] for name in NAMES}
    outside = [f"{name}, {z:.3f}" for name, z in deviations.items() if not Z[0] <= z <= Z[1]]
    judged = f"Of all tests the deviation of z lies outside of {Z[0]} to {Z[1]} for: {'; '.join(outside) or 'none'}."
    by_seed = [
        f"seed {seed} " + ", ".join(f"{PARAMETERS[name]} {of[f'deviation_of_z_{name}']:.3f}" for name in NAMES)
        for seed, of in ((seed, summary_of_tests(some)) for seed, some in rows.groupby("seed"))
    ]
    judged += f" By seed it is: {'; '.join(by_seed)}."
    return f"{table(['', *bands], lines)}\n\n{judged}\n\nWhy tests were refused: {why}."


def free_rocking(_: Data) -> str:
    """How often intervals of free-rocking tests hold the truth, and which damper they exclude: the stored check."""
    rows = pd.read_csv(FREE_ROCKING)
    judged, counted = rows.dropna(subset="deviation_of_z"), rows[rows["deviation_of_z"].isna()]
    counts = rows.groupby("made_by", sort=False)[["tests", "refused"]].first()
    each = "; ".join(f"{maker} {int(one['tests'])}, {int(one['refused'])}" for maker, one in counts.iterrows())
    share = counted.pivot_table(index="made_by", columns="parameter", values="share").reindex(counts.index)
    dampers = list(dict.fromkeys(counted["parameter"]))
    head = ["made by", *(name.removesuffix(" excluded") for name in dampers)]
    losses = pd.read_csv(LOSSES)
    return (
        f"Specimens and how many of them were refused: {each}.\n\n{_intervals(judged)}\n\n"
        f"The losses alone, of {losses['tests'][0]} specimens of each kind:\n\n{_intervals(losses)}\n\n"
        "Share of specimens whose tests exclude a damper, by what made them:\n\n"
        f"{table(head, [[maker, *map(percent, row)] for maker, row in share[dampers].iterrows()])}"
    )


def _intervals(rows: pd.DataFrame) -> str:
    """Return the table of a check's parameters: how often an interval holds the truth, z, and the ranks."""
    head = ["made by", "parameter", "within its interval", "deviation of z", "probability of the ranks"]
    shown = [
        [
            row["made_by"],
            {"e": "e at 0.3 u_ins"}.get(row["parameter"], row["parameter"]),
            f"{percent(row['share'])} ± {percent(row['standard_error'])}",
            f"{row['deviation_of_z']:.2f}",
            f"{row['rank_probability']:.2g}",
        ]
        for row in rows.to_dict("records")
    ]
    return table(head, shown)


def slips(_: Data) -> str:
    """How `calibrate` ends with honest records of each maker, and with records that have a slip: the stored check."""
    rows = pd.read_csv(SLIPS)
    honest = rows["slip"] == "none"
    kinds = pd.concat(["honest, made by " + rows.loc[honest, "maker"], rows.loc[~honest, "slip"]])
    ends = pd.crosstab(kinds, rows["ended"]).reindex(columns=["answered", "warned", "refused"], fill_value=0)
    shown = [[kind, *map(str, ends.loc[kind])] for kind in kinds.drop_duplicates()]
    reasons = rows.loc[honest & (rows["ended"] == "refused"), "reason"]
    causes = {
        "the record begins within the motion": reasons.str.contains("samples at rest").sum(),
        "b1 at an end of its range": reasons.str.contains("the best fit has strength_ratio").sum(),
        "the misfit": reasons.str.contains("the best fit leaves").sum(),
    }
    causes["another reason"] = len(reasons) - sum(causes.values())
    why = "; ".join(f"{words}: {int(count)}" for words, count in causes.items())
    head = ["record", "answered", "with a warning", "refused"]
    return f"{table(head, shown)}\n\nWhy honest records were refused: {why}."
