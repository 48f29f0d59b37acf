"""A viscous damping ratio for a coefficient of restitution: closed form, least error, polynomials.

Each method is a function. Studies choose the cases and store the results.
"""
