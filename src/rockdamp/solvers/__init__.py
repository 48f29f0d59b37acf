"""Two ways to solve the equation of motion: the fast stepper over many histories, and the event-driven reference.

They share no stepping code, so that each can check the other; what a history means is read elsewhere.
"""


def compile_all() -> None:
    """Compile every loop that the pipeline runs, into Numba's cache, so that later processes find it there.

    A short run of each damper by each scheme, of ECD by each order that is compiled for itself and by one that is not,
    and of each law by the event-driven solver.
    """
    from rockdamp.mechanics.curve import TrilinearCurve
    from rockdamp.mechanics.damping import Damping
    from rockdamp.mechanics.damping.ecd import MULTIPLIED_ORDERS
    from rockdamp.solvers.event_driven import history
    from rockdamp.solvers.newmark import SCHEMES, solve
    from rockdamp.vocabulary import MODELS

    curve = TrilinearCurve(0.04, 0.85)
    dampers = [Damping(model, 0.5) for model in MODELS]
    for damping in dampers:
        history(curve, damping, [0.01], release_amplitude=0.5)
    orders = [Damping("ECD", 0.05, order=order) for order in (*MULTIPLIED_ORDERS, 2.5)]
    for scheme in SCHEMES:
        further = [Damping.power(1.3, 0.05), *orders] if scheme == "newmark" else []
        for damping in (*dampers, *further):
            solve(curve, damping, release_amplitude=0.5, step=0.01, steps=1, scheme=scheme)
