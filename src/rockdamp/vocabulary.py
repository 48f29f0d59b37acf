"""The studies of free decay, and the parameter that each varies: its dimension in the datasets."""

STUDIES = {
    "amplitude": "release_amplitude",
    "slenderness": "slenderness",
    "overburden": "overburden_ratio",
    "cracked_stiffness": "cracked_stiffness_ratio",
}
