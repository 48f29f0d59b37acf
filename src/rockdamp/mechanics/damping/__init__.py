"""The damping models: the coefficient of restitution and the viscous dampers, a file each.

Dimensionless as in the solvers: unit mass, C over m_eff p. Eqs (8), (10), (11), (12) of the paper; ECD is beyond it.
`base` says what a damper must have.
"""

from rockdamp.mechanics.damping.base import REFERENCE_AMPLITUDE, Damping, damper_classes

__all__ = ["REFERENCE_AMPLITUDE", "Damping", "damper_classes"]
