"""The damping models that the documents show: the reference and those with shipped polynomials.

A model just added is not one of them.
"""

from rockdamp.constants import MODELS, REFERENCE
from rockdamp.equivalence.polynomials import shipped_polynomials

PUBLISHED_VISCOUS = tuple(model for model in MODELS if model in shipped_polynomials().coefficient)
PUBLISHED = (REFERENCE, *PUBLISHED_VISCOUS)
