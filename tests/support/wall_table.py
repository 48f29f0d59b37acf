"""A table of walls of every kind, one of them bad."""

TABLE = """# walls of the school
id,thickness,height,overburden_ratio,parapet,a1,b1,a3,softening,preset,restitution,one_sided,diaphragm_period
a,0.25,3.0,0.5,,,,,,new,0.85,,
bad,,3.0,,,,,,,new,,,

b,0.2,1.2,,yes,,,,,severe,,,
c,0.30,4.5,1,,0.04,0.80,0.9,translated,,0.80,,
front,0.80,12,,yes,0.04,0.85,,,,0.5,yes,
floor,0.25,3.0,0.5,no,,,,,new,impulsive,,0.4s
"""
