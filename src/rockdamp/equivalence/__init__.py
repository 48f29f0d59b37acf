"""From a coefficient of restitution to a viscous damping ratio: closed form, least error, polynomials.

One function for each; which cases are asked for, and where results are stored, is for studies.
"""
