"""First peak of a released wall in Siconos, run by the system's Python.

Reads matrices as JSON on standard input, writes the peak [m]. Debian: python3-siconos.
"""

import json
import sys

import numpy as np
import siconos.kernel as sk

problem = json.load(sys.stdin)
q0 = np.array(problem["q"])
bodies = sk.LagrangianLinearTIDS(q0, np.zeros(q0.size), np.array(problem["mass"]))
bodies.setKPtr(sk.SimpleMatrix(-np.array(problem["push"])))
force = np.array(problem["force"])
bodies.setFExtPtr(force)
model = sk.NonSmoothDynamicalSystem(0.0, 1e3)
model.insertDynamicalSystem(bodies)
interactions = []  # Siconos does not hold them itself


def link(row, law):
    interaction = sk.Interaction(law, sk.LagrangianLinearTIR(np.array([row])))
    model.link(interaction, bodies)
    interactions.append(interaction)


for row in problem["gaps"]:
    link(row, sk.NewtonImpactNSL(problem["restitution"]))
for row in problem["held"]:
    link(row, sk.EqualityConditionNSL(1))
discretisation = sk.TimeDiscretisation(0.0, problem["step"])
stepping = sk.TimeStepping(model, discretisation, sk.MoreauJeanOSI(0.5), sk.MLCP())
hinge = np.array(problem["hinge"])
last_rate = 0.0
while True:
    stepping.computeOneStep()
    rate = hinge @ bodies.velocity()
    u = hinge @ bodies.q()
    if last_rate < 0 <= rate and u < 0:
        break
    last_rate = rate
    stepping.nextStep()
print(abs(u))
