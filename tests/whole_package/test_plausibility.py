"""The impossible is refused and the unlikely warned of: in Python, on the command line and in the config alike."""

import numpy as np
import pytest
from click.testing import CliRunner

import rockdamp as rd
from rockdamp import plausibility, stated
from rockdamp.cli import main

CURVE, DAMPING = rd.TrilinearCurve(0.04, 0.85), rd.Damping("CDR", 0.05)


@pytest.mark.parametrize(
    ("kind", "thickness", "height", "expected"),
    [
        (rd.Wall, 3.0, 0.24, "h/t = 0.08; it must be at least 1; were the two swapped?"),
        (
            rd.Wall,
            4.0,
            3.0,
            "h/t = 0.75; it must be at least 1; was the thickness in inches or feet, or is it the wall's width?",
        ),
        (rd.Wall, 240.0, 3.0, "h/t = 0.0125; it must be at least 1; was the thickness in millimetres?"),
        (rd.Wall, 0.3, 0.25, "h/t = 0.833; it must be at least 1"),
        (rd.Wall, 0.3, 0.4, "h/t = 1.33; e is -0.173 by Eq. (7); it must be above 0"),
        (
            rd.Parapet,
            1.5,
            0.3,
            "h/t = 0.2; e is -0.442 by Housner's formula; it must be above 0; were the two swapped?",
        ),
    ],
)
def test_a_wall_that_cannot_rock_is_refused_with_the_slip_that_makes_it(kind, thickness, height, expected):
    with pytest.raises(rd.InputError) as caught:
        kind(thickness, height)
    assert str(caught.value) == f"thickness is {thickness:g} m and height {height:g} m, which is {expected}"


@pytest.mark.parametrize(
    ("thickness", "height", "slip"),
    [
        (240.0, 3000.0, "were they in millimetres?"),
        (0.24, 3000.0, "was the height in millimetres or centimetres?"),
        (0.3, 1001.0, "was the height in millimetres or centimetres or inches?"),
    ],
)
def test_sizes_that_no_building_has_are_refused(thickness, height, slip):
    with pytest.raises(rd.InputError) as caught:
        rd.Wall(thickness, height)
    said = f"thickness is {thickness:g} m and height {height:g} m; they must be at most 100 m and 1000 m; {slip}"
    assert str(caught.value) == said


@pytest.mark.parametrize(
    ("thickness", "height", "expected"),
    [
        (
            24.0,
            300.0,
            "thickness is 24 m and height 300 m, more than 2 m and 30 m; were they in centimetres or inches?",
        ),
        (0.24, 300, "height is 300 m, more than 30 m; was the height in centimetres or inches?"),
        (2.5, 12.0, "thickness is 2.5 m, more than 2 m; were they in feet?"),
    ],
)
def test_sizes_beyond_what_is_built_are_warned_of_where_they_were_written(thickness, height, expected):
    with pytest.warns(rd.InputWarning) as caught:
        rd.Wall(thickness, height)
    assert [str(one.message) for one in caught] == [expected]
    assert caught[0].filename == __file__


@pytest.mark.parametrize("sizes", [(2.0, 30.0), (0.15, 3.0), (np.array([1.5, 2.0]), 30.0)])
def test_sizes_within_what_is_built_are_not_warned_of(sizes):
    rd.Parapet(*sizes)  # a warning is an error here


def test_damping_beyond_any_walls_is_warned_of_where_it_is_used():
    with pytest.warns(rd.InputWarning, match=r"damping_ratio \(xi\) is 5, more than 0\.5; was it in per cent"):
        rd.free_decay(CURVE, rd.Damping("CDR", 5.0), length=1.0)
    rd.free_decay(CURVE, rd.Damping("CDR", 0.5), length=1.0)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"density": 18}, "density is 18 kg m-3, less than 300; was it in kN m-3 (1835 kg m-3)?"),
        ({"density": 1.8}, "density is 1.8 kg m-3, less than 300; was it in t m-3 (1800 kg m-3)?"),
        ({"density": [2000, 112]}, "density is 112 kg m-3, less than 300; was it in lb ft-3 (1794 kg m-3)?"),
        ({"density": 5000}, "density is 5000 kg m-3, more than 3500"),
        (
            {"overburden_ratio": 15},
            "overburden_ratio is 15 times the wall's weight, more than 10; was it in kN per metre",
        ),
        ({"overburden_ratio": [1, 30000]}, "more than 10; was it in N per metre (O/W 2.27)?"),
    ],
)
def test_a_density_or_overburden_that_no_wall_has_is_questioned(given, said):
    """A wall of 250 mm by 3 m at 1800 kg/m3 weighs 13.24 kN per metre."""
    with pytest.warns(rd.InputWarning) as caught:
        rd.Wall(0.25, 3.0, width=2.0, **given)
    assert len(caught) == 1 and said in str(caught[0].message)


def pulse(pga):
    elapsed = 0.01 * np.arange(100)
    return rd.Record(elapsed, pga * np.sin(2 * np.pi * elapsed))


@pytest.mark.parametrize(
    ("pga", "scale", "expected"),
    [
        (0.03, 1.0, r"PGA is 0\.03 m s-2, under 0\.005 g, .* in g \(0\.294 m s-2\)"),
        (300.0, 1.0, r"PGA is 300 m s-2, over 3 g, .* in cm s-2 \(3 m s-2\)"),
        (3.0, 100.0, r"PGA is 300 m s-2, over 3 g: 3 m s-2 times the scale of 100"),
        (3.0, [-100.0, 200.0], r"over 3 g"),
    ],
)
def test_a_motion_weaker_or_stronger_than_earthquakes_is_warned_of(pga, scale, expected):
    with pytest.warns(rd.InputWarning, match=expected) as caught:
        rd.respond(rd.Wall(0.3, 4.5), CURVE, DAMPING, pulse(pga), scale=scale)
    assert len(caught) == 1


def test_the_command_line_says_each_doubt_once_in_one_line():
    decay = "decay --preset new --damping-model CDR --damping-ratio 5 --thickness 24 --height 300 --length 20"
    result = CliRunner().invoke(main, decay.split())
    assert result.exit_code == 0
    lines = [line for line in result.stderr.splitlines() if line.startswith("warning")]
    assert [line.split(" is ")[0] for line in lines] == ["warning: thickness", "warning: damping_ratio (xi)"]
    refused = CliRunner().invoke(main, "wall --thickness 3 --height 0.24".split())
    assert refused.exit_code == 2 and "were the two swapped?" in refused.stderr


@pytest.mark.parametrize(
    ("doubts", "said"),
    [
        (plausibility.of_step(3.90625), "were the times in milliseconds (0.00391 s)?"),
        (
            plausibility.of_exponent([0.3, 5.0]),
            "exponent (g) is 5, more than 1: a large impact then loses hardly anything",
        ),
        (plausibility.of_step(3.90625e-6), "were the times in seconds (0.00391 s)?"),
    ],
)
def test_channels_in_another_unit_are_questioned(doubts, said):
    assert len(doubts) == 1 and doubts[0].endswith(said)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: rd.Damping.cr(85), r"at most 1; was it in per cent \(0.85\)\?"),
        (lambda: rd.equivalent(85, 0.04, 0.85), r"at most 1; was it in per cent \(0.85\)\?"),
        (lambda: rd.Wall(0.3, 4.5, hinge_ratio=57), r"both excluded; was it in per cent \(0.57\)\?"),
        (lambda: rd.Damping.cr(1.2), "at most 1$"),
        (lambda: rd.TrilinearCurve(4, 0.85), r"\(1 - b1\); was it in per cent \(0.04\)\?"),
    ],
)
def test_a_percentage_is_recognised(make, said):
    with pytest.raises(rd.InputError, match=said):
        make()


def test_a_curve_that_no_wall_has_is_questioned():
    with pytest.warns(rd.InputWarning, match=r"a1\) is 0.0004, less than 0.002: nearly a rigid block; was it 0.04"):
        rd.equivalent(0.85, 0.0004, 0.85)
    with pytest.warns(rd.InputWarning, match=r"b1\) is 0.085, less than 0.3"):
        rd.equivalent(0.85, 0.04, 0.085)
    with pytest.warns(rd.InputWarning, match=r"restitution \(e\) is 0.05, less than 0.5; was it a damping ratio"):
        rd.giannini_masiani(0.05)
    assert plausibility.of_curve(0.5, 0.2)[0].endswith("were a1 and b1 swapped?")  # of the preset severe
    assert plausibility.of_curve([0.005, 0.2], [0.4, 0.99]) == plausibility.of_curve([], []) == []


def test_warnings_of_several_values_name_the_one_that_is_furthest_off():
    """Of motions in both units: 2 g is 19.6 m s-2."""
    assert plausibility.in_g(2 * 9.80665) == "19.6 m s-2 (2 g)"
    (told,) = plausibility.of_damping([0.1, 0.6, 0.9])
    assert told.startswith("damping_ratio (xi) is 0.9,")
    assert plausibility.of_damping(0.0005) == ["damping_ratio (xi) is 0.0005, less than 0.001; was it 0.05?"]
    assert plausibility.of_damping([0.0, 0.001]) == plausibility.of_damping(0.0) == []
    (told,) = plausibility.of_restitution([0.9, 0.2, 0.4])
    assert told.startswith("restitution (e) is 0.2,")
    (told,) = plausibility.of_onset([50.0, 40.0])  # the easiest of the walls
    assert "begins to rock at 40 m s-2 (4.08 g)" in told
    (told,) = plausibility.of_supports([20.0, 40.0])  # the most shaken of the supports
    assert "the supports peak at 40 m s-2 (4.08 g)" in told


@plausibility.as_meant()  # when it is made
def test_the_height_of_a_building_is_questioned():
    def asked(wall, storeys=None):
        return [doubt.rpartition("; ")[2] for doubt in stated.of_stated(wall, storeys)]

    assert asked(rd.Wall(0.4, 9.6), 3)[0].endswith("was it that of the building (3 storeys of 3.2 m)?")
    assert asked(rd.Wall(0.3, 6.0), 2)[0].endswith("was it that of the building (2 storeys of 3 m)?")
    assert asked(rd.Wall(0.8, 9.6)) == ["was it that of the building, or in feet (2.93 m)?"]
    assert asked(rd.Wall(0.25, 6.5)) == ["was it that of the building?"]
    for height in (1.5, 2.0):
        assert asked(rd.Wall(0.3, height)) == [
            f"was it half of it ({2 * height:g} m), or is the wall a parapet, or a specimen?"
        ]
    assert asked(rd.Parapet(0.25, 3.0), 3) == ["does it stand free, or is it a wall below a floor?"]
    assert (
        asked(rd.Parapet(1.0, 1.2)) == asked(rd.Wall(1.0, 3.0)) == ["is the thickness right, and not the wall's width?"]
    )
    assert asked(rd.Parapet(0.25, 6.0)) == ["are both right?"]
    assert asked(rd.Wall(0.3, 3.0, hinge_ratio=0.88)) == ["was it the restitution (e)?"]
    for wall in (rd.Wall(0.3, 3.2), rd.Wall(0.5, 8.0), rd.Wall([0.2, 0.3], 3.0), rd.Parapet(0.25, 1.0)):
        assert asked(wall, None) == []


def test_heights_of_a_table_that_are_half_or_twice_those_of_the_others_are_asked_about():
    asked = stated.of_heights({2: 4.4, 3: 4.4, 4: 2.2, 5: 4.2, 6: 6.0})
    assert asked == {4: "the height is 2.2 m, where most are some 4.4 m; was it half of it?"}
    asked = stated.of_heights({2: 3.0, 3: 3.1, 4: 6.2, 5: 2.9})
    assert asked[4].endswith("was it that of 2 storeys of 3.1 m?") and len(asked) == 1
    assert stated.of_heights({2: 4.4, 3: 2.2}) == {}


def test_per_cent_of_g_in_a_column_of_g_is_recognised():
    (told,) = plausibility.of_motion(30 * 9.80665, "g", 9.80665)
    assert "per cent of g (2.94 m s-2)" in told


def test_solve_asks_about_damping_where_a_user_calls_it():
    with pytest.warns(rd.InputWarning, match=r"damping_ratio \(xi\) is 5, .*was it in per cent \(0\.05\)"):
        rd.solve(CURVE, rd.Damping("CDR", [5.0, 3.0]), step=0.01, steps=10, release_amplitude=0.5)


def test_a_wall_narrower_than_it_is_thick_is_asked_about():
    with pytest.warns(rd.InputWarning, match="width is 0.23 m, less than the thickness of 1 m; were the two swapped"):
        rd.Wall(1.0, 3.2, width=0.23)
    rd.Wall(1.2, 6.0)  # of a metre's width, the default: no warning, which were an error here
