"""The damping models that the documents show: those of which the package ships polynomials, and the reference.

A damper that was just added is in the vocabulary and works everywhere; the documents show it once it is published.
"""

from rockdamp.equivalence.polynomials import shipped
from rockdamp.vocabulary import MODELS, REFERENCE

PUBLISHED_VISCOUS = tuple(model for model in MODELS if model in shipped().coefficient)
PUBLISHED = (REFERENCE, *PUBLISHED_VISCOUS)
