"""Two rigid bodies on contacts under a ground motion: the time stepping of `contacts`, compiled."""

import numpy as np
from contacts import TwoBodiesOnContacts
from numba import njit

CLOSED = 1e-12  # largest gap of a closed contact [m]


def shaken_peak(wall, ground, step, substeps, limit):
    """Return the largest |u| of a wall from rest [m]; infinity beyond `limit`, where it collapses.

    `ground` is the acceleration of both supports [m s-2], linear between samples `step` apart [s].
    """
    bodies = TwoBodiesOnContacts(wall)
    sets = [np.array(active, dtype=int) for active in bodies.solvers]
    members = np.zeros((len(sets), len(bodies.gaps)), dtype=bool)
    solvers = np.zeros((len(sets), len(bodies.gaps), len(bodies.gaps)))
    for row, active in enumerate(sets):
        members[row, active] = True
        solvers[row][np.ix_(active, active)] = -bodies.solvers[tuple(active)]
    free = bodies.free
    sideways = np.diag(bodies.mass) * [1, 0, 0, 1, 0, 0]
    return march(
        bodies.inverse @ (free.T @ bodies.force),
        bodies.inverse @ (free.T @ bodies.push @ free),
        bodies.inverse @ (free.T @ sideways),
        bodies.inverse @ bodies.lift.T,
        np.ascontiguousarray(bodies.lift),
        bodies.delassus,
        members,
        solvers,
        bodies.hinge @ free,
        ground,
        step / substeps,
        substeps,
        limit,
    )


@njit
def march(
    force,
    push,
    sideways,
    press,
    lift,
    delassus,
    members,
    solvers,
    hinge,
    ground,
    h,
    substeps,
    limit,
):
    """Advance the free coordinates by Moreau's midpoint rule; forces are over the inertia."""
    q = np.zeros(len(force))
    s = np.zeros(len(force))
    peak = 0.0
    last = 0
    for sample in range(len(ground) - 1):
        for part in range(substeps):
            share = (part + 0.5) / substeps
            a = ground[sample] + share * (ground[sample + 1] - ground[sample])
            q_half = q + h / 2 * s
            s_free = s + h * (force + push @ q_half - sideways * a)
            closed = lift @ q_half <= CLOSED
            impulse, last = find_impulses(lift @ s_free, closed, delassus, members, solvers, last)
            s = s_free + press @ impulse
            q = q_half + h / 2 * s
            u = abs(hinge @ q)
            if u > limit:
                return np.inf
            peak = max(peak, u)
    return peak


@njit
def find_impulses(speed, closed, delassus, members, solvers, last):
    """Return the impulses that leave no closed contact closing, and their active set's number."""
    small = 1e-9 * np.abs(speed).max() + 1e-300
    for number in range(-1, len(members)):
        active = last if number < 0 else number
        if np.any(members[active] & ~closed):
            continue
        impulse = solvers[active] @ speed
        end_speed = speed + delassus @ impulse
        if impulse.min() >= -small and np.all((end_speed >= -small) | ~closed):
            return impulse, active
    raise AssertionError("no impulses meet the law of impact")
