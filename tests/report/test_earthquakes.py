"""The report's section on earthquakes: its numbers are those of the datasets, and its words follow them."""

import dataclasses
import re
from html import unescape

import made_up_earthquakes as made_up
import numpy as np
import xarray as xr
from configs import configured

from rockdamp import report
from rockdamp.report import earthquakes
from rockdamp.text import number

CONFIG = configured({"earthquakes": {"restitution_change": 0.017}, "curve": {"strength_ratio": 0.83}})


def datasets(compared=None):
    compared = made_up.comparison() if compared is None else compared
    advice = made_up.recommendation(compared)
    return {"comparison": compared, "recommendation": advice, "earthquakes/walls": made_up.walls()}


def told(compared=None, **more):
    """The section's text."""
    html = str(earthquakes.section({**datasets(compared), **more}, CONFIG))
    return " ".join(unescape(re.sub(r"<[^>]+>", " ", html)).replace("\xa0", " ").split())


def scaled(name, factor, **where):
    """The made-up comparison with one statistic and its interval times a factor, where told."""
    compared = made_up.comparison()
    for key in (name, f"{name}_interval"):
        chosen = xr.ones_like(compared[key], dtype=bool)
        for dim, label in where.items():
            chosen = chosen & (compared[dim] == label)
        compared[key] = compared[key].where(~chosen, factor * compared[key])
    return made_up.with_excess(compared)


# --- what was run -----------------------------------------------------------------------------------------------------


def test_what_was_run_is_counted_from_the_datasets():
    text = told()
    ratios = int(np.isfinite(made_up.walls()["damping_ratio"]).sum())
    histories = 100 * made_up.SCALE.size * (ratios + len(made_up.WALLS) * made_up.E.size)
    assert "5 walls were shaken by 100 horizontal components of 50 stations" in text
    assert f"{histories:,}".replace(",", " ") in text.replace("\u202f", " ")
    assert "for 99.00 % of them" in text and ", 4 % for 99 %." in text
    assert "without degraded, which has none" in text and "e lower by 0.017" in text


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


# --- which damper -----------------------------------------------------------------------------------------------------


def test_what_the_dataset_recommends_is_named_with_what_is_as_good():
    text = told()
    words = "At e = 0.8, 0.85 and 0.9 no other damper has a significantly (95 %) smaller error than CDR with ξ of the "
    assert f"Use CDR. {words}polynomials or the least error or the closed form." in text
    assert "As good at every e: ECD (ξ: polynomials)." in text


def test_the_ratio_that_leads_is_compared_with_the_closed_form_where_it_gains_most_and_by_collapses_missed():
    compared = made_up.comparison()
    error, missed = (compared[name] for name in ("log_error", "false_safe_rate"))
    at = {"band": 0, "restitution": 0.85}
    leading = float(error.sel(damping_model="CDC", damping_ratio_source="least error", **at))
    error.loc[{"damping_model": "CDC", "damping_ratio_source": "closed form", "band": 0}] = 1.5 * leading
    missed.loc[{"damping_model": "CDC", "damping_ratio_source": "closed form"}] = 0.01
    text = told(compared)
    both = f"errs {number(leading, 2)} with it, and {number(1.5 * leading, 2)} with the closed form, at e = 0.85"
    assert "Take the ξ of least error. rockdamp equivalent gives it ( damping_ratio )" in text
    assert f"Under earthquakes CDC {both}." in text
    assert "The price: CDC misses 3 % of the collapses there with it, and 1 % with the closed form." in text
    missed.loc[{"damping_model": "CDC", "damping_ratio_source": "closed form"}] = 0.04
    assert "The price" not in told(compared)


# --- when not ---------------------------------------------------------------------------------------------------------


def test_amplitudes_where_the_error_is_beyond_that_sensitivity_are_named():
    assert (
        "At every e studied it does so for peaks of CR of 0.01 to 0.04, 0.04 to 0.1, 0.1 to 0.25, 0.25 to 0.5 and"
        " 0.5 to 1" in told()
    )
    text = told(scaled("log_error", 3.0, band=2))
    assert "For 0.04 to 0.1 u ins it holds at no e." in text and text.count("✗ does not") == 3
    text = told(scaled("log_error", 3.0, band=2, restitution=0.9))
    assert "For 0.04 to 0.1 u ins it depends on e." in text and text.count("✗ does not") == 1


def test_the_fragility_is_called_safe_unsafe_or_not_different_by_its_interval():
    assert told().count("not significantly different from 1.") == 3
    assert told(scaled("median_intensity_ratio", 1.1)).count("higher: the damper is unsafe by that much") == 3
    assert told(scaled("median_intensity_ratio", 0.9)).count("lower: the damper is safe by that much") == 3
    assert told(scaled("median_intensity_ratio", np.nan)).count("too few collapses for a fragility") == 3


def test_walls_whose_median_differs_from_that_of_restitution_are_named():
    assert "At no wall does the median intensity of collapse with CDR differ significantly from CR's." in told()
    for factor in (0.9, 1.2):
        text = told(scaled("wall_median_intensity_ratio", factor, wall="church", damping_model="CDR", restitution=0.9))
        assert (
            "Walls whose median intensity of collapse with CDR differs significantly from CR's: church (e = 0.9)."
            in text
        )
    # The ratio alone decides: a median outside the interval of CR's own may well be of a pair that does not differ.
    moved = scaled("wall_median_velocity_ratio", 1.5, wall="church", damping_model="CDR")
    assert "At no wall does the median intensity of collapse with CDR differ significantly from CR's." in told(moved)


# --- tables and gaps --------------------------------------------------------------------------------------------------


def test_every_damper_and_source_has_a_row_at_every_e_with_its_numbers():
    text = told()
    for model, ratio in zip(made_up.MODELS[1:], made_up.FACTOR[1:], strict=True):
        shown = number(ratio)
        for source in earthquakes.SOURCES.values():
            assert len(re.findall(rf"{model} {source} {re.escape(shown)} \(", text)) == made_up.E.size
    assert text.count("0.100 (0.0890 to 0.111)") == made_up.E.size  # SDR of the polynomials, more than the least
    assert "step four times as long 0.010; 0.015;" in text and "e higher by 0.017 0.070; 0.11;" in text


def tables_of(compared):
    """Every table of the section, as lists of the texts of its cells."""
    html = unescape(str(earthquakes.section(datasets(compared), CONFIG))).replace("\xa0", " ")
    return [
        [re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", line) for line in re.findall(r"<tr.*?</tr>", table, re.DOTALL)]
        for table in re.findall(r"<table.*?</table>", html, re.DOTALL)
    ]


def test_missed_and_added_collapses_stand_each_in_its_own_column():
    compared = made_up.comparison()  # 3 % of the collapses and 2 % of the survivals
    varied = xr.zeros_like(compared["varied_false_safe_rate"])
    compared = compared.assign(varied_false_safe_rate=varied + 0.5, varied_false_collapse_rate=varied + 0.25)
    of_dampers = [lines for lines in tables_of(compared) if "ξ from" in lines[0]]
    assert len(of_dampers) == made_up.E.size
    for head, *lines in of_dampers:
        for name, rate in (("Missed, of CR's collapses", "3 % "), ("Added, of CR's survivals", "2 % ")):
            assert lines and all(line[head.index(name)].startswith(rate) for line in lines)
    assert "near collapse; collapses missed; collapses added" in told(compared)
    (of_cr,) = [lines for lines in tables_of(compared) if any("step four times" in line[0] for line in lines)]
    for _, *cells in of_cr[1:]:
        assert all(cell.endswith("; 50 %; 25 %") for cell in cells)


def test_a_study_too_small_for_any_number_has_dashes_and_no_recommendation():
    compared = made_up.comparison()
    statistics = [key for key, values in compared.data_vars.items() if values.dtype.kind == "f"]
    text = told(compared.assign({key: compared[key] * np.nan for key in statistics} | {"converged_share": 1.0}))
    assert "there are too few peaks to judge" in text and "Use " not in text
    assert "nan" not in text and "not defined" not in text and "–" in text


def test_without_the_study_the_report_has_no_section_on_it(short, html):
    gone = {name for name in short.datasets if name.startswith("earthquakes")}
    less = {name: data for name, data in short.datasets.items() if name not in gone}
    without = report.build(dataclasses.replace(short, datasets=less))
    assert 'id="earthquakes"' not in without and 'href="#earthquakes"' not in without
    assert 'id="earthquakes"' in html
