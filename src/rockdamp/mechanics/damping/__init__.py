"""The damping models: the coefficient of restitution and the viscous dampers, one class each behind one face.

Dimensionless as in the kernels: unit mass, C over m_eff p. Eqs (8), (10), (11), (12) of the paper; ECD is beyond it.
"""

from rockdamp.mechanics.damping.energy_consistent import MULTIPLIED_ORDERS
from rockdamp.mechanics.damping.face import SCHEMES, Damping
from rockdamp.mechanics.damping.viscous import Viscous

# A model is known once its module was loaded: each stands here.
import rockdamp.mechanics.damping.restitution  # noqa: F401  isort: skip

__all__ = ["MULTIPLIED_ORDERS", "SCHEMES", "Damping", "Viscous"]
