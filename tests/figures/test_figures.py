"""What the figures show: the data, units, colours and labels, on small made-up datasets; never pixels."""

import errno
import re
import subprocess
import sys
from functools import cache
from itertools import combinations
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_up_studies import ALL, STEPS, VISCOUS, E, equivalence, made_up, match, validation
from matplotlib.axis import Axis
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.text import Text

from rockdamp.figures import FIGURES, save
from rockdamp.figures.equivalence import PAPER_RANGE
from rockdamp.figures.mechanism import bodies, rotations
from rockdamp.figures.style import DOUBLE_COLUMN, INCH, MODELS, SINGLE_COLUMN, shades
from rockdamp.figures.validation import shown

INPUTS = {
    "fig1": ["mechanism"],
    "fig2": ["mechanism"],
    "fig3": ["loops"],
    "fig4": ["loops"],
    "fig5": ["amplitude"],
    "fig6": ["slenderness", "overburden", "cracked_stiffness"],
    "fig6_error": ["amplitude"],
    "fig7": ["equivalence"],
    "fig8": ["validation"],
    "fig_orders": ["orders"],
    "fig_dispersion": ["dispersion"],
    "fig_exponent": ["dispersion"],
    "fig_closed_form": ["dispersion"],
    "fig_pulses": ["pulses"],
    "fig_spectra": ["pulses"],
    "fig_natural": ["natural", "comparison"],
    "fig_natural_ratio": ["comparison"],
    "fig_ida": ["comparison"],
    "fig_fragility": ["comparison"],
    "fig_population": ["population"],
}
SMALLEST_TEXT = 7  # [pt], the house's limit for print


# --- made-up datasets: smooth functions of the right shape, no solver ------------------------------------------------


def draw(name):
    return FIGURES[name](*(made_up()[source] for source in INPUTS[name]))


@cache
def drawn(name):
    """A figure with everything in its final place."""
    figure = draw(name)
    figure.draw_without_rendering()
    return figure


# --- reading a figure ------------------------------------------------------------------------------------------------


def lines(axes, colour=None):
    found = [line for line in axes.get_lines() if line.get_xdata().__len__() > 2]
    return [line for line in found if colour is None or to_rgb(line.get_color()) == pytest.approx(to_rgb(colour))]


def shows(axes, x, y):
    """Whether one of the lines of a panel is exactly these points."""
    return any(
        np.shape(line.get_ydata()) == np.shape(y)
        and np.allclose(line.get_xdata(), x, rtol=1e-12)
        and np.allclose(line.get_ydata(), y, rtol=1e-12, atol=1e-15, equal_nan=True)
        for line in axes.get_lines()
    )


def labelled(axes, start):
    (found,) = (line for line in axes.get_lines() if str(line.get_label()).startswith(start))
    return found


def texts(figure):
    """Every text that is seen, tick labels and legends included."""
    on_ticks, seen = set(), []
    for axis in figure.findobj(Axis):
        low, high = sorted(axis.get_view_interval())
        slack = 1e-6 * (high - low)
        for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
            on_ticks |= {tick.label1, tick.label2}
            if axis.axes.axison and axis.get_visible() and low - slack <= tick.get_loc() <= high + slack:
                seen += [tick.label1, tick.label2]
    seen += [text for text in figure.findobj(Text) if text not in on_ticks]
    off = {axes.xaxis.label for axes in figure.axes if not axes.axison}
    off |= {axes.yaxis.label for axes in figure.axes if not axes.axison}
    return [text for text in seen if text.get_text().strip() and text.get_visible() and text not in off]


def all_text(figure):
    return "\n".join(text.get_text() for text in texts(figure))


def panel_titled(figure, start):
    (found,) = (axes for axes in figure.axes if axes.get_title().startswith(start))
    return found


# --- every figure ----------------------------------------------------------------------------------------------------


def test_every_figure_of_the_paper_is_there():
    elsewhere = ["fig_accuracy", "fig_rigid"]  # in test_accuracy.py, beside the stage that makes their dataset
    assert sorted(FIGURES) == sorted([*INPUTS, *elsewhere])


@pytest.mark.parametrize("name", INPUTS)
def test_every_axis_has_a_label_with_its_unit(name):
    for axes in drawn(name).axes:
        if not axes.axison:
            continue
        shown_ticks = {
            axes.xaxis: any(label.get_text() and label.get_visible() for label in axes.get_xticklabels()),
            axes.yaxis: any(label.get_text() and label.get_visible() for label in axes.get_yticklabels()),
        }
        for axis, has_ticks in shown_ticks.items():
            label = axis.get_label_text()
            assert not label or re.search(r"\[.+\]", label), f"{name}: no unit in {label!r}"
            # Of panels that share an axis, one may speak for all.
            peers = axes.get_shared_x_axes() if axis is axes.xaxis else axes.get_shared_y_axes()
            which = "xaxis" if axis is axes.xaxis else "yaxis"
            spoken = [getattr(peer, which).get_label_text() for peer in peers.get_siblings(axes)]
            assert not has_ticks or any(spoken), f"{name}: an axis with numbers and no label"


@pytest.mark.parametrize("name", INPUTS)
def test_text_is_large_enough_for_print_and_inside_the_figure(name):
    figure = drawn(name)
    page = figure.bbox
    for text in texts(figure):
        assert text.get_fontsize() >= SMALLEST_TEXT, text.get_text()
        box = text.get_window_extent()
        within = (
            page.x0 <= box.x0 + 0.5 and box.x1 <= page.x1 + 0.5 and page.y0 <= box.y0 + 0.5 and box.y1 <= page.y1 + 0.5
        )
        assert within, f"{name}: {text.get_text()!r} is cut off"


@pytest.mark.parametrize("name", INPUTS)
def test_no_text_lies_on_another(name):
    figure = drawn(name)
    boxes = [(text.get_text(), text.get_window_extent()) for text in texts(figure)]
    for (one, a), (other, b) in combinations(boxes, 2):
        overlap = min(a.x1, b.x1) - max(a.x0, b.x0), min(a.y1, b.y1) - max(a.y0, b.y0)
        assert min(overlap) < 2, f"{name}: {one!r} lies on {other!r}"


@pytest.mark.parametrize("name", INPUTS)
def test_legends_do_not_cover_data(name):
    for axes in drawn(name).axes:
        legend = axes.get_legend()
        if legend is not None:
            box = legend.get_window_extent()
            for line in axes.get_lines():
                path = line.get_transform().transform_path(line.get_path())
                guide = len(line.get_xdata()) == 2  # lines along an axis, slopes
                assert guide or not path.intersects_bbox(box, filled=False), f"{name}: {line.get_label()!r}"


@pytest.mark.parametrize("name", INPUTS)
def test_figures_have_the_width_of_one_or_two_columns(name):
    width, height = drawn(name).get_size_inches() * INCH
    assert width == pytest.approx(SINGLE_COLUMN) or width == pytest.approx(DOUBLE_COLUMN)
    assert height <= 240  # a page's text


@pytest.mark.parametrize("name", ["fig3", "fig4", "fig6_error", "fig7", "fig8", "fig_orders"])
def test_a_model_has_one_colour_line_and_marker_everywhere(name):
    seen = set()
    for axes in drawn(name).axes:
        title = axes.get_title().split(",")[0].split(" ")[0]
        for line in axes.get_lines():
            model = re.match(r"(CR|CDC|CDR|SDR|ECD)\b", str(line.get_label()))
            model = model[1] if model else title if line.get_label() == "computed" else None
            if model:
                assert to_rgb(line.get_color()) == to_rgb(MODELS[model].colour)
                assert line.get_marker() in ("None", MODELS[model].marker)
                seen.add(model)
    assert seen == {"fig4": {"CR", "CDR"}, "fig8": set(ALL), "fig_orders": set(ALL)}.get(name, set(VISCOUS))


def test_models_are_told_apart_without_colour():
    assert list(MODELS) == ALL
    for one, other in combinations(MODELS.values(), 2):
        assert one.linestyle != other.linestyle and one.marker != other.marker and one.colour != other.colour


def test_shades_of_a_model_run_from_light_to_dark_through_its_colour():
    luminance = [0.2126 * r + 0.7152 * g + 0.0722 * b for r, g, b in shades("CDR", 5)]
    assert np.all(np.diff(luminance) < 0)
    assert shades("CDR", 5)[2] == pytest.approx(to_rgb(MODELS["CDR"].colour), abs=0.01)
    assert len(shades("SDR", 1)) == 1


def test_what_is_beyond_the_paper_is_told_apart():
    for name in ("fig3", "fig5", "fig6", "fig6_error", "fig7", "fig8"):
        assert "beyond the paper" in all_text(drawn(name)), name


# --- Fig. 1 ----------------------------------------------------------------------------------------------------------

WALLS = {
    "thickness": st.floats(0.05, 1.0),
    "slenderness": st.floats(4.0, 30.0),
    "hinge_ratio": st.floats(0.3, 0.75),
    "part": st.floats(0.0, 1.0),
}


@settings(max_examples=50, deadline=None)
@given(**WALLS)
def test_bodies_keep_their_dimensions_and_pivots(thickness, slenderness, hinge_ratio, part):
    height = slenderness * thickness
    lower, upper = bodies(thickness, height, hinge_ratio, part * thickness)
    for body, tall in ((lower, hinge_ratio * height), (upper, (1 - hinge_ratio) * height)):
        edges = np.diff(np.vstack([body, body[:1]]), axis=0)
        assert np.hypot(*edges.T) == pytest.approx([thickness, tall, thickness, tall])
        assert np.hypot(*(body[2] - body[0])) == pytest.approx(np.hypot(thickness, tall))  # right angles
    assert lower[1] == pytest.approx([thickness, 0.0])  # C' stays
    assert upper[0] == pytest.approx(lower[3])  # both meet at B
    assert lower[3, 0] == pytest.approx(part * thickness)  # which moves by u
    assert upper[2, 0] == pytest.approx(thickness)  # A' moves up, not sideways
    assert upper[2, 1] >= height - 1e-9 * height
    assert lower[:, 1].min() >= -1e-9 * height  # nothing goes into the ground
    assert upper[:, 1].max() == pytest.approx(upper[2, 1])  # nor through the top support


def test_rotations_are_those_of_section_2_for_small_displacements():
    u = 1e-4
    assert rotations(0.3, 4.5, 0.7, u) == pytest.approx((u / (0.7 * 4.5), u / (0.3 * 4.5)), rel=1e-3)


def test_fig1_draws_the_wall_rigid_in_both_states():
    rest, displaced = drawn("fig1").axes
    for axes in (rest, displaced):
        assert axes.get_aspect() == 1.0
    shapes = [
        [patch.get_xy()[:4] for patch in axes.patches if isinstance(patch, Polygon) and patch.get_fill()][:2]
        for axes in (rest, displaced)
    ]
    for still, moved in zip(*shapes, strict=True):
        sides = [np.hypot(*np.diff(np.vstack([body, body[:1]]), axis=0).T) for body in (still, moved)]
        assert sides[0] == pytest.approx(sides[1])
    lower, upper = shapes[0]
    assert (lower[3] - lower[0])[1] / (upper[3] - lower[0])[1] == pytest.approx(0.7)  # h1/h of the dataset


def test_fig1_names_every_symbol_and_admits_its_exaggeration():
    text = all_text(drawn("fig1"))
    for symbol in (
        "$h_1$",
        "$h_2$",
        "$t$",
        "$u$",
        "$O$",
        "ecc",
        "$W_1$",
        "$W_2$",
        r"$\alpha_1$",
        r"$\alpha_2$",
        r"$\theta_1$",
        r"$\theta_2$",
        "$A'$",
        "$B$",
        "$C'$",
        "exaggerated",
        "3 times",
        "h/t = 15",
    ):
        assert symbol in text, symbol


# --- Fig. 2 ----------------------------------------------------------------------------------------------------------


def test_fig2_draws_every_curve_of_the_dataset():
    panels, curves = drawn("fig2").axes, made_up()["mechanism"]
    for name, places in {
        "bi-linear": (0, 1, 2),
        "tri-linear": (0,),
        "steeper": (1,),
        "translated": (1,),
        "new": (2,),
        "moderate": (2,),
        "severe": (2,),
    }.items():
        for place in places:
            assert shows(panels[place], curves["displacement"], curves["force"].sel(curve_name=name)), name


def test_the_secant_of_fig2_runs_from_the_origin_to_the_curve():
    secant = labelled(drawn("fig2").axes[0], "secant")
    (x0, x1), (y0, y1) = secant.get_data()
    curve = made_up()["mechanism"]["force"].sel(curve_name="tri-linear")
    assert (x0, y0) == (0, 0)
    assert y1 == pytest.approx(float(curve.interp(displacement=x1)))


def test_fig2_marks_the_corners_and_gives_the_presets():
    figure = drawn("fig2")
    above, beside = figure.axes[0].child_axes
    assert above.get_xticks() == pytest.approx([0.04, 0.15, 1.0])
    assert beside.get_yticks() == pytest.approx([0.85, 1.0])
    text = all_text(figure)
    for symbol in ("$u_1$", "$u_2$", "u_3", "$F_y$", "$F_0$", "$K_0$", r"$K_\mathrm{sec}$", "severe: $a_1 = 0.20$"):
        assert symbol in text, symbol


# --- Figs 3 and 4 ----------------------------------------------------------------------------------------------------


def test_fig3_shows_the_laws_and_says_that_ecd_has_none():
    axes, data = drawn("fig3").axes[0], made_up()["loops"]
    for model in ("CDC", "CDR", "SDR"):
        assert shows(axes, data["frequency_ratio"], data["damping_ratio_law"].sel(viscous_model=model))
    assert "no function" in labelled(axes, "ECD").get_label()


def test_fig3_shows_the_whole_loop_of_every_model_with_its_damping_ratio():
    axes, data = drawn("fig3").axes[1], made_up()["loops"]
    for model in VISCOUS:
        one = data.sel(damping_model=model)
        pale, strong = lines(axes, MODELS[model].colour)
        assert f"{float(one['damping_ratio']):.4f}" in strong.get_label()
        together = np.concatenate([strong.get_xdata()[:-1], pale.get_xdata()])
        assert together == pytest.approx(one["displacement"].values)
        together = np.concatenate([strong.get_ydata()[:-1], pale.get_ydata()])
        assert together == pytest.approx(one["damping_force"].values)


def test_the_strong_loop_of_fig3_ends_at_the_second_peak_after_the_release():
    strong = lines(drawn("fig3").axes[1], MODELS["CDC"].colour)[1].get_xdata()
    # The made-up decay has its peaks every pi/1.3 in tau, a little early for its damping.
    assert strong.size * 0.01 == pytest.approx(2 * np.pi / 1.3, rel=0.02)


def test_fig4_shows_three_rocking_decays_in_tau_and_in_seconds():
    axes, data = drawn("fig4").axes[0], made_up()["loops"]
    for name in data["rocking_model"].values:
        assert shows(axes, data["tau"], data["rocking_displacement"].sel(rocking_model=name))
    seconds = axes.child_axes[0]
    assert seconds.get_xlim()[1] == pytest.approx(axes.get_xlim()[1] / 3.8)


def test_fig4_shows_the_jump_of_cr_and_the_smooth_velocity_of_cdr():
    _, upper, lower = drawn("fig4").axes
    data = made_up()["loops"]
    for axes, variable in ((upper, "displacement"), (lower, "velocity")):
        for model in ("CR", "CDR"):
            line = labelled(axes, model)
            shown_part = data.isel(tau=slice(0, len(line.get_xdata())))
            assert line.get_xdata() == pytest.approx(shown_part["tau"].values)
            assert line.get_ydata() == pytest.approx(shown_part[variable].sel(damping_model=model).values)
    (inset,) = lower.child_axes
    jumps = [np.abs(np.diff(line.get_ydata())).max() for line in inset.get_lines()]
    assert jumps[0] > 5 * jumps[1]  # the inset is where CR jumps


# --- Figs 5 to 7 -----------------------------------------------------------------------------------------------------


def test_fig5_shows_the_papers_amplitudes_and_no_others_with_the_closed_form():
    data = made_up()["amplitude"]
    for model, axes in zip(VISCOUS, drawn("fig5").axes, strict=True):
        assert axes.get_title().startswith(model)
        assert len(lines(axes)) == 6
        for amplitude in (0.9, 0.5, 0.3):
            one = data.sel(damping_model=model, release_amplitude=amplitude)
            assert shows(axes, E, one["damping_ratio"])
            assert shows(axes, E, one["damping_ratio_energy"])
            matched = labelled(axes, rf"$u_0/u_\mathrm{{ins}} = {amplitude:g}$")
            assert matched.get_ydata() == pytest.approx(one["damping_ratio"].values)


def test_fig5_draws_what_there_is_where_the_papers_amplitudes_are_missing():
    figure = FIGURES["fig5"](match("release_amplitude", [0.25, 0.6]))
    assert len(lines(figure.axes[0])) == 4


def test_fig6_shows_every_wall_and_what_a_length_in_seconds_changes():
    panels = np.reshape(drawn("fig6").axes, (5, 4))
    for strips, row, name, parameter in (
        (panels[0], panels[1], "slenderness", "slenderness"),
        (panels[2], panels[3], "overburden", "overburden_ratio"),
    ):
        data = made_up()[name]
        for column, model in enumerate(VISCOUS):
            for value in data[parameter].values:
                one = data.sel({"damping_model": model, parameter: value})
                fixed = one["damping_ratio_fixed_seconds"]
                assert shows(row[column], E, one["damping_ratio"])
                assert shows(row[column], E, fixed)
                assert shows(strips[column], E, 1000 * (fixed - one["damping_ratio"]))


def test_fig6_shows_a1_only_where_the_plateau_is_the_first_ones():
    row, data = np.reshape(drawn("fig6").axes, (5, 4))[4], made_up()["cracked_stiffness"]
    for axes, model in zip(row, VISCOUS, strict=True):
        assert len(lines(axes)) == 3
        for a1 in (0.02, 0.04, 0.14):
            assert shows(axes, E, data["damping_ratio"].sel(damping_model=model, cracked_stiffness_ratio=a1))
    legend = row[-1].get_legend()
    assert [text.get_text() for text in legend.get_texts()] == ["0.02", "0.04", "0.14"]
    assert "0.85" in legend.get_title().get_text()


def test_fig6_error_shows_the_root_of_err_and_the_papers_range():
    axes, data = drawn("fig6_error").axes[0], made_up()["amplitude"].sel(release_amplitude=0.5)
    for model in VISCOUS:
        assert labelled(axes, model).get_ydata() == pytest.approx(
            np.sqrt(data["error"].sel(damping_model=model).values)
        )
    (shaded,) = axes.patches
    assert (shaded.get_x(), shaded.get_x() + shaded.get_width()) == pytest.approx(PAPER_RANGE)
    assert PAPER_RANGE == (0.80, 0.91)  # Section 6
    # The second axis is the root mean square, in thousandths.
    assert f"k = {STEPS}" in axes.get_title()
    (beside,) = axes.child_axes
    assert beside.get_ylim()[1] == pytest.approx(1000 * axes.get_ylim()[1] / np.sqrt(STEPS))


def test_fig6_error_names_the_papers_model_with_the_lowest_error():
    axes = drawn("fig6_error").axes[0]
    rows = {line.get_marker(): line.get_xdata() for line in axes.get_lines() if line.get_linestyle() == "None"}
    assert rows[MODELS["SDR"].marker] == pytest.approx(E[E < 0.795])
    assert rows[MODELS["CDR"].marker] == pytest.approx(E[E > 0.795])
    assert rows[MODELS["CDC"].marker].size == 0
    assert MODELS["ECD"].marker not in rows


def test_fig7_shows_polynomials_matched_points_and_equation_15():
    together, *panels = drawn("fig7").axes
    data = made_up()["equivalence"]
    for axes in (together, *panels):
        assert shows(axes, E, data["giannini_masiani"])
    for axes, model in zip(panels, VISCOUS, strict=True):
        assert axes.get_title().startswith(model)
        for a1 in data["cracked_stiffness_ratio"].values:
            one = data.sel(damping_model=model, cracked_stiffness_ratio=a1)
            assert shows(axes, E, one["damping_ratio_fit"])
            (points,) = (
                line
                for line in axes.get_lines()
                if line.get_marker() == "." and line.get_ydata()[0] == float(one["damping_ratio"][0])
            )
            assert np.all(np.isin(points.get_ydata(), one["damping_ratio"]))
        fit = data["damping_ratio_fit"].sel(damping_model=model)
        assert labelled(together, model).get_ydata() == pytest.approx(fit.sel(cracked_stiffness_ratio=0.04).values)
    # Rounded down: a figure must not claim more than the least fit.
    assert "0.9987" in all_text(drawn("fig7"))


def test_fig7_says_what_its_curves_share_where_the_dataset_does():
    data = equivalence().assign(plateau_ratio=0.85, release_amplitude=0.5)
    text = all_text(FIGURES["fig7"](data))
    assert "$b_1 = 0.85$" in text and r"u_\mathrm{ins} = 0.5$" in text and r"\tau = 8" in text


# --- Fig. 8 ----------------------------------------------------------------------------------------------------------


def test_fig8_shows_the_measurement_and_every_model_in_millimetres():
    data = made_up()["validation"]
    for model in ALL:
        axes = panel_titled(drawn("fig8"), f"{model}")
        assert shows(axes, data["elapsed"], 1000 * data["measured"])
        assert shows(axes, data["elapsed"], 1000 * data["displacement"].sel(damping_model=model))
        number = "0.835" if model == "CR" else f"{float(data['damping_ratio'].sel(damping_model=model)):.4f}"
        assert number in axes.get_title()
    assert shows(panel_titled(drawn("fig8"), "table"), data["elapsed"], data["ground_acceleration"])


def test_fig8_marks_the_peaks_on_the_side_where_they_are():
    data = made_up()["validation"]
    axes = panel_titled(drawn("fig8"), "SDR")
    marks = [line for line in axes.get_lines() if line.get_linestyle() == "None"]
    sides = np.array([1, -1, 1, -1])
    for line, peaks in zip(
        marks, (data["measured_decay_peak"], data["decay_peak"].sel(damping_model="SDR")), strict=True
    ):
        assert line.get_ydata() == pytest.approx(1000 * sides * peaks.values)


@pytest.mark.parametrize("said, synthetic", [("yes", True), ("no", False), (None, True), ("No idea", True)])
def test_fig8_calls_a_record_synthetic_unless_it_says_that_it_is_not(said, synthetic):
    data = validation(record_synthetic=said)
    if said is None:
        del data.attrs["record_synthetic"]
    text = all_text(FIGURES["fig8"](data))
    assert text.count("SYNTHETIC") == (2 if synthetic else 0)  # the heading and the legend


def test_fig8_says_where_a_model_collapsed():
    data = validation()
    data["collapsed"][3] = 1
    for name in ("rms_misfit", "peak_ratio_to_measured"):
        data[name][3] = np.nan
    data["decay_peak"][3] = np.nan
    data["displacement"][3, 200:] = np.nan
    figure = FIGURES["fig8"](data)
    assert "collapsed" in [text.get_text() for text in panel_titled(figure, "SDR").texts]
    assert "nan" not in all_text(figure)


def test_fig8_starts_shortly_before_the_motion_and_ends_after_the_last_peak():
    start, end = shown(validation())
    # The bell of 0.1 s around 1.5 s first passes a tenth of its peak at 1.5 - 0.1 sqrt(ln 10).
    assert 1.0 < start < 1.5 - 0.1 * np.sqrt(np.log(10)) + 0.01
    assert 1.5 + 3.5 * np.pi / 8 < end < 4


# --- orders ----------------------------------------------------------------------------------------------------------


def test_fig_orders_shows_errors_measured_orders_and_true_slopes():
    data = made_up()["orders"]
    panels = iter(drawn("fig_orders").axes)
    for scheme in ("newmark", "paper"):
        for excitation in ("free", "forced"):
            axes, one = next(panels), data.sel(scheme=scheme, excitation=excitation)
            assert axes.get_xscale() == axes.get_yscale() == "log"
            for model in ALL:
                curve = one.sel(damping_model=model)
                line = labelled(axes, f"{model}:")
                assert line.get_ydata() == pytest.approx(curve["solver_error"].values)
                assert f"{float(curve['order']):.2f} ({float(curve['finest_order']):.2f})" in line.get_label()
            guides = [line for line in axes.get_lines() if str(line.get_label()).startswith("_")]
            slopes = [np.polyfit(np.log(line.get_xdata()), np.log(line.get_ydata()), 1)[0] for line in guides]
            assert slopes == pytest.approx([1.0, 2.0])


# --- saving ----------------------------------------------------------------------------------------------------------


def test_two_saves_of_a_figure_drawn_twice_are_the_same_bytes(tmp_path, monkeypatch):
    monkeypatch.delenv("SOURCE_DATE_EPOCH", raising=False)
    formats = ("pdf", "png", "svg")
    for folder in ("one", "two"):
        written = save(draw("fig6_error"), tmp_path / folder / "figure", formats, 100)
        assert written == [tmp_path / folder / f"figure.{suffix}" for suffix in formats]
    for suffix in formats:
        first, second = ((tmp_path / folder / f"figure.{suffix}").read_bytes() for folder in ("one", "two"))
        assert first == second, suffix
        assert b"CreationDate" not in first and b"dc:date" not in first
    assert sorted(path.name for path in (tmp_path / "one").iterdir()) == ["figure.pdf", "figure.png", "figure.svg"]


def test_resolution_sets_the_pixels_of_the_print_size(tmp_path):
    (path,) = save(draw("fig6_error"), tmp_path / "figure", ["png"], 100)
    width = int.from_bytes(path.read_bytes()[16:20], "big")  # of the PNG's header
    assert width == pytest.approx(SINGLE_COLUMN / INCH * 100, abs=1)


def test_a_name_with_a_dot_is_kept_whole(tmp_path):
    (path,) = save(Figure(figsize=(1, 1)), tmp_path / "fig.v1", ["png"], 50)
    assert path.name == "fig.v1.png"


def test_a_failed_save_leaves_the_earlier_file_and_nothing_else(tmp_path, monkeypatch):
    figure = Figure(figsize=(1, 1))
    (path,) = save(figure, tmp_path / "figure", ["png"], 50)
    before = path.read_bytes()

    def break_off(target, content):
        with target.open("wb") as file:
            file.write(content[:4])
        raise OSError(errno.ENOSPC, "disk full")

    monkeypatch.setattr(Path, "write_bytes", break_off)
    with pytest.raises(OSError, match=r"disk full: '.*figure\.png'"):
        save(figure, tmp_path / "figure", ["png"], 50)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_an_unknown_format_is_an_error_and_writes_nothing(tmp_path):
    with pytest.raises(ValueError, match="nonsense"):
        save(Figure(figsize=(1, 1)), tmp_path / "figure", ["nonsense"], 50)
    assert list(tmp_path.iterdir()) == []


def test_the_users_own_style_changes_nothing(tmp_path):
    (path,) = save(draw("fig6_error"), tmp_path / "plain", ["png"], 80)
    with matplotlib.rc_context({"font.size": 20, "axes.facecolor": "black", "savefig.dpi": 30}):
        (other,) = save(draw("fig6_error"), tmp_path / "styled", ["png"], 80)
        assert matplotlib.rcParams["font.size"] == 20  # and the figures change nothing of the user's
    assert path.read_bytes() == other.read_bytes()


def test_importing_the_figures_does_not_load_the_solver():
    code = "import sys, rockdamp.figures; print(*sorted(sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "rockdamp.figures" in loaded
    for name in ("numba", "rockdamp.kernels", "rockdamp.solvers.newmark", "matplotlib.pyplot"):
        assert name not in loaded
