"""First peak of a released wall in Siconos, by the system's Python: two bodies, what lies on them, contacts, supports.

Reads matrices as JSON on standard input, writes the peak [m]. Debian: python3-siconos.
"""

import json
import sys

import numpy as np
import siconos.kernel as sk

given = json.load(sys.stdin)
q0, mass, load = (np.array(given[name]) for name in ("q", "mass", "force"))
bodies = sk.LagrangianLinearTIDS(q0, np.zeros(q0.size), mass)
bodies.setKPtr(sk.SimpleMatrix(-np.array(given["push"])))
bodies.setFExtPtr(load)
model = sk.NonSmoothDynamicalSystem(0.0, 1e3)
model.insertDynamicalSystem(bodies)
kept = []
for rows, law in (
    (given["gaps"], lambda: sk.NewtonImpactNSL(given["restitution"])),
    (given["held"], lambda: sk.EqualityConditionNSL(1)),
):
    for row in rows:
        interaction = sk.Interaction(law(), sk.LagrangianLinearTIR(np.array([row])))
        model.link(interaction, bodies)
        kept.append(interaction)
stepping = sk.TimeStepping(
    model, sk.TimeDiscretisation(0.0, given["step"]), sk.MoreauJeanOSI(0.5), sk.MLCP()
)
hinge, before = np.array(given["hinge"]), 0.0
while True:
    stepping.computeOneStep()
    rate, u = hinge @ bodies.velocity(), hinge @ bodies.q()
    if before < 0 <= rate and u < 0:
        break
    before = rate
    stepping.nextStep()
print(abs(u))
