"""The report's section on earthquakes: its numbers are those of the datasets."""

import dataclasses
import re
from html import unescape

import made_up_earthquakes as made_up
import numpy as np
import xarray as xr

from rockdamp import report
from rockdamp.report import earthquakes
from rockdamp.text import number


def told(compared=None, **more):
    """The section's text."""
    compared = made_up.comparison() if compared is None else compared
    html = str(earthquakes.section({"comparison": compared, "earthquakes/walls": made_up.walls(), **more}))
    return " ".join(unescape(re.sub(r"<[^>]+>", " ", html)).replace("\xa0", " ").split())


# --- what was run -----------------------------------------------------------------------------------------------------


def test_what_was_run_is_counted_from_the_datasets():
    text = told()
    ratios = int(np.isfinite(made_up.walls()["damping_ratio"]).sum())
    histories = 100 * made_up.SCALE.size * (ratios + len(made_up.WALLS) * made_up.E.size)
    assert "5 walls were shaken by 100 horizontal components of 50 stations" in text
    assert f"{histories:,}".replace(",", " ") in text.replace("\u202f", " ")
    assert "for 99.00 % of them" in text and ", 4 % for 99 %." in text
    assert "without degraded, which has none" in text


def sample():
    """Two strata of the study that have histories, and one that has none."""
    return xr.Dataset(
        {
            "study_count": ("stratum", [12345, 0, 20]),
            "checked_count": ("stratum", [40, 0, 20]),
            "otherwise_share": ("stratum", [0.0, np.nan, 0.05]),
            "beyond_bound_share": ("stratum", [0.025, np.nan, np.nan]),
            "median_difference": ("stratum", [0.0004, np.nan, 0.002]),
            "largest_difference": ("stratum", [0.011, np.nan, 0.13]),
        },
        coords={"stratum": ["far", "near", "unconverged"]},
    )


def test_samples_solved_event_by_event_are_told_by_stratum_where_there_are_any():
    assert "event by event" not in told()
    text = told(**{"earthquakes/check": sample()}).replace("\u202f", " ")
    assert "Histories of the study, solved again event by event" in text
    assert "survives, peak below 0.5 u ins 12 345 40 0 % 2.5 % 0.040 % 1.1 %" in text
    assert "outcome depends on the step 20 20 5 % – 0.20 % 13 %" in text
    assert "survives, 0.5 to 0.8 u ins" not in text


def test_histories_whose_bound_exceeds_their_peak_are_named_once():
    histories = made_up.earthquakes()
    assert "exceeds the peak" not in told(earthquakes=histories)
    at = {"record": "far-field/2/a", "velocity_ratio": made_up.SCALE[0], "wall": "church", "restitution": 0.85}
    bound, peak = (histories[name] for name in ("peak_uncertainty", "peak"))
    bound.loc[{**at, "damping_model": "CR"}] = 2 * peak.loc[{**at, "damping_model": "CR"}]  # from every source
    bound.loc[{**at, "damping_model": "SDR", "damping_ratio_source": "polynomial"}] = 3 * peak.sel(
        **at, damping_model="SDR", damping_ratio_source="polynomial"
    )
    text = told(earthquakes=histories)
    assert "The bound exceeds the peak itself in 2 histories" in text
    rows = re.findall(r"far-field/2/a church 0.200 0.85 (\w+) (\w+|–) \S+ (\d)", text)
    assert rows == [("SDR", "polynomials", "3"), ("CR", "–", "2")]


# --- tables and gaps --------------------------------------------------------------------------------------------------


def test_every_damper_and_source_has_a_row_at_every_e_with_its_numbers():
    text = told()
    for model, ratio in zip(made_up.MODELS[1:], made_up.FACTOR[1:], strict=True):
        shown = number(ratio)
        for source in earthquakes.SOURCES.values():
            assert len(re.findall(rf"{model} {source} {re.escape(shown)} \(", text)) == made_up.E.size


def test_missed_and_added_collapses_stand_each_in_its_own_column():
    html = unescape(
        str(earthquakes.section({"comparison": made_up.comparison(), "earthquakes/walls": made_up.walls()}))
    ).replace("\xa0", " ")
    tables = [
        [re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", line) for line in re.findall(r"<tr.*?</tr>", table, re.DOTALL)]
        for table in re.findall(r"<table.*?</table>", html, re.DOTALL)
    ]
    shown = [lines for lines in tables if "ξ from" in lines[0]]
    assert len(shown) == made_up.E.size
    for head, *lines in shown:  # 3 % of the collapses and 2 % of the survivals
        for name, rate in (("Missed, of CR's collapses", "3 % "), ("Added, of CR's survivals", "2 % ")):
            assert lines and all(line[head.index(name)].startswith(rate) for line in lines)


def test_the_errors_of_each_band_are_those_of_the_leading_ratio():
    compared = made_up.comparison()
    at = {"damping_model": "CDR", "damping_ratio_source": "least error", "restitution": 0.85, "band": 2}
    compared["median_ratio"].loc[at], compared["log_error_median"].loc[at], compared["log_error_90"].loc[at] = (
        1.23,
        0.45,
        0.67,
    )
    assert "1.23; 0.45; 0.67" in told(compared)


def test_a_study_too_small_for_any_number_has_dashes():
    compared = made_up.comparison()
    statistics = [key for key, values in compared.data_vars.items() if values.dtype.kind == "f"]
    text = told(compared.assign({key: compared[key] * np.nan for key in statistics} | {"converged_share": 1.0}))
    assert "nan" not in text and "–" in text


def test_without_the_study_the_report_has_no_section_on_it(short, html):
    gone = {name for name in short.datasets if name.startswith("earthquakes")}
    less = {name: data for name, data in short.datasets.items() if name not in gone}
    without = report.build(dataclasses.replace(short, datasets=less))
    assert 'id="earthquakes"' not in without and 'href="#earthquakes"' not in without
    assert 'id="earthquakes"' in html
