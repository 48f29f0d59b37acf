"""Names and values that the whole package shares. Imports nothing."""

STANDARD_GRAVITY = 9.80665  # [m s-2], CODATA

# The studies of free decay, and the parameter that each varies: its dimension in the datasets.
STUDIES = {
    "amplitude": "release_amplitude",
    "slenderness": "slenderness",
    "overburden": "overburden_ratio",
    "cracked_stiffness": "yield_displacement_ratio",
}

RECOMMENDED = "BAND"  # of the viscous dampers; docs/theory.md, section 9, derives it
# The source of the damping ratio with which commands, report, documents and figures lead: `damping_ratio` of the
# commands. docs/earthquakes.md says why, with the errors under earthquakes.
RECOMMENDED_SOURCE = "least error"

# The damping models that are compared, in the order of the datasets: the coefficient of restitution first.
MODELS = ("CR", "CDC", "CDR", "SDR", "ECD", "BAND")
REFERENCE = "CR"  # the model that the viscous dampers stand in for
VISCOUS_MODELS = tuple(model for model in MODELS if model != REFERENCE)
PAPER_MODELS = ("CDC", "CDR", "SDR")  # the viscous dampers of the paper; the others go beyond it

# Doherty's stages of degradation, quoted in section 3 of the paper: (b1, a1).
PRESETS = {"new": (0.72, 0.06), "moderate": (0.60, 0.13), "severe": (0.50, 0.20)}

# Variants of a curve's last branch for a3 < 1.
SOFTENING = ("steeper", "translated")

# ASSUME: the length of the response, in tau, which the paper does not state. `response_lengths.infer` says how it was
# inferred, and a test keeps it equal to results/response_lengths.nc.
DEFAULT_RESPONSE_LENGTH = 8.0

# ASSUME: how far e of one wall, and of one block, lies from the rule for it: standard deviations. The tests of walls
# that the paper quotes have 0.85 to 0.91 of Eq. (7), mean 0.86; reports of other walls and blocks, second-hand, 0.90 to
# 0.97 of theory. A deviation of 0.03 about 0.90 has all but the last within two. A block's is that of ln e in measured
# free-rocking trials, over all slendernesses, and a test keeps it equal to results/measured_rocking.nc.
WALL_RESTITUTION_DEVIATION = 0.03
BLOCK_RESTITUTION_DEVIATION = 0.024
# What a constant e costs where it was measured in small releases, 0.1 u_ins: the intensity that a wall survives is
# overstated by this share, if walls lose as measured blocks do. A test keeps it to the table of docs/earthquakes.md.
RELEASES = "0.3 to 0.5 u_ins"  # those that a constant e is meant for
SMALL_RELEASE_OVERSTATES = "5 to 15 % with g = 0.13 to 0.39"
