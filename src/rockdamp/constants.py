"""Names and values that the whole package shares. The module imports nothing."""

STANDARD_GRAVITY = 9.80665  # [m s-2], CODATA

# The studies of free decay, and the parameter that each varies, which is its dimension in the
# datasets.
STUDIES = {
    "amplitude": "release_amplitude",
    "slenderness": "slenderness",
    "overburden": "overburden_ratio",
    "cracked_stiffness": "yield_displacement_ratio",
}

# The damping models that are compared, in the order of the datasets: the coefficient of restitution
# first.
MODELS = ("CR", "CDC", "CDR", "SDR", "ECD", "BAND")
REFERENCE = "CR"  # the model that the viscous dampers replace
VISCOUS_MODELS = tuple(model for model in MODELS if model != REFERENCE)
PAPER_MODELS = ("CDC", "CDR", "SDR")  # the viscous dampers of the paper; the others go beyond it

RECOMMENDED = "BAND"  # the viscous damper to use; docs/theory.md, section 9, derives it
# The source of the damping ratio with which commands, report, documents and figures lead:
# `damping_ratio` of the commands. docs/earthquakes.md gives the reason, with the errors under
# earthquakes.
RECOMMENDED_SOURCE = "least error"

# Doherty's stages of degradation, quoted in section 3 of the paper: (b1, a1).
PRESETS = {"new": (0.72, 0.06), "moderate": (0.60, 0.13), "severe": (0.50, 0.20)}

# Variants of the last branch of a curve for a3 < 1.
SOFTENING = ("steeper", "translated")

# ASSUME: the length of the response in tau, which the paper does not state.
# `response_lengths.infer` infers it, and a test keeps it equal to results/response_lengths.nc.
DEFAULT_RESPONSE_LENGTH = 8.0

# ASSUME: standard deviation of e of one wall from the rule for it. The tests of walls that the
# paper quotes have 0.85 to 0.91 of Eq. (7), mean 0.86; reports of other walls and blocks, from a
# secondary source, 0.90 to 0.97 of theory. Two deviations of 0.03 about 0.90 cover 0.84 to 0.96,
# all these ratios but the largest.
WALL_RESTITUTION_DEVIATION = 0.03
# Standard deviation of ln e of one block in measured free-rocking trials, over all slendernesses; a
# test keeps it equal to results/measured_rocking.nc.
BLOCK_RESTITUTION_DEVIATION = 0.024

RELEASES = "0.3 to 0.5 u_ins"  # amplitudes of the releases that a constant e is meant for
# A constant e measured in small releases, 0.1 u_ins, overstates the intensity that a wall survives
# by this share, if walls lose energy as measured blocks do. A test keeps the text equal to the
# table of docs/earthquakes.md.
SMALL_RELEASE_OVERSTATES = "5 to 15 %"
