"""Two ways to solve the equation of motion: the fast stepper over many histories, and the event-driven reference.

They share no stepping code, so that each can check the other; what a history means is read elsewhere.
"""


def compile_all() -> None:
    """Compile the fast stepper, so that jobs that start at the same time find it in Numba's cache."""
    from rockdamp.mechanics.curve import TrilinearCurve
    from rockdamp.mechanics.damping import Damping
    from rockdamp.solvers.newmark import solve

    for model, value in (("CR", 0.9), ("CDC", 0.05), ("CDR", 0.05), ("SDR", 0.05), ("ECD", 0.05)):
        solve(TrilinearCurve(0.04, 0.85), Damping(model, value), release_amplitude=0.5, step=0.01, steps=1)
