"""Two rigid bodies on contacts, in small rotations: Moreau's time stepping with Newton's law of impact.

Nothing of the mechanism is put in: each body has x, y and a rotation, corners may lift and land, faces do not slide,
and the supports hold what they hold. Hinges, strength and restitution come out. Where a part of the overburden has a
mass, it is a third body that moves up and down and lies on the head; it may lift off.
"""

from itertools import combinations

import numpy as np
from scipy.linalg import null_space


class TwoBodiesOnContacts:
    """q = (x1, y1, theta1, x2, y2, theta2, y3) from the upright wall; theta anticlockwise, y3 of the slab if any."""

    def __init__(self, wall):
        t, h1, h2 = (
            float(np.asarray(x)) for x in (wall.thickness, wall.lower_height, wall.upper_height)
        )
        m = float(wall.mass) * np.array([h1, h2]) / (h1 + h2)
        turning = m * (t**2 + np.array([h1, h2]) ** 2) / 12
        part = float(wall.overburden_mass) * float(wall.overburden)
        slab = [part / 9.80665] if part else []
        self.mass = np.diag([m[0], m[0], turning[0], m[1], m[1], turning[1], *slab])

        def corner(body, dx, dy):
            """Rows of x and y of a body's point, at (dx, dy) from its centre."""
            rows = np.zeros((2, len(self.mass)))
            rows[0, 3 * body : 3 * body + 3] = 1, 0, -dy
            rows[1, 3 * body : 3 * body + 3] = 0, 1, dx
            return rows

        sides = (-t / 2, t / 2)
        foot = [corner(0, s, -h1 / 2) for s in sides]
        below, above = [corner(0, s, h1 / 2) for s in sides], [corner(1, s, -h2 / 2) for s in sides]
        head = corner(1, 0.0, h2 / 2)
        self.hinge = below[0][0]  # x of the hinge, u
        # No sliding at the foot and between the bodies; the head is held sideways and free to rise.
        self.held = np.array([foot[0][0], above[0][0] - below[0][0], head[0]])
        self.gaps = np.array(
            [*(f[1] for f in foot), *(a[1] - b[1] for a, b in zip(above, below, strict=True))]
        )
        weights = -9.80665 * (m[0] * corner(0, 0, 0)[1] + m[1] * corner(1, 0, 0)[1])
        self.force = weights - (float(wall.overburden) - part) * head[1]
        if slab:
            lies = np.zeros(7)
            lies[6] = 1
            self.gaps = np.array([*self.gaps, lies - head[1]])
            self.force = self.force - part * lies
        # The weights and the overburden, raised less at larger rotations: half of K0, as u carries half of the mass.
        self.push = float(wall.rigid_stiffness) / 2 * np.outer(self.hinge, self.hinge)

        self.free = null_space(self.held)  # the motions that slide nowhere
        self.inverse = np.linalg.inv(self.free.T @ self.mass @ self.free)
        g = self.gaps @ self.free
        self.delassus, self.lift = g @ self.inverse @ g.T, g
        self.solvers = {}
        for size in range(len(self.inverse) + 1):
            for active in map(list, combinations(range(len(g)), size)):
                part = self.delassus[np.ix_(active, active)]
                if size == 0 or np.linalg.cond(part) < 1e10:
                    self.solvers[tuple(active)] = np.linalg.inv(part) if size else part
        self.last = (0, 1, 2)

        # Where the top has moved by one more than the base: both bodies lie along the tilted line of the supports.
        h = h1 + h2
        self.tilted = np.zeros(len(self.mass))
        self.tilted[:6] = h1 / 2 / h, 0, -1 / h, (h1 + h2 / 2) / h, 0, -1 / h
        self.sideways = np.zeros(len(self.mass))
        self.sideways[[0, 3]] = m
        # What weights and overburden gain of potential by the square of each body's own rotation, whatever held it.
        load, (w1, w2) = float(wall.overburden), 9.80665 * m
        self.sinking = np.zeros(self.mass.shape)
        self.sinking[2, 2] = h1 * (w1 / 2 + w2 + load)
        self.sinking[5, 5] = h2 * (w2 / 2 + load)

    def impulses(self, speed, closed):
        """Return P >= 0 of the contacts: w = speed + delassus P >= 0 and w P = 0 where closed, P = 0 elsewhere."""
        small = 1e-9 * np.abs(speed).max() + 1e-300
        for active in [self.last, *self.solvers]:
            if not (set(active) <= closed and active in self.solvers):
                continue
            impulse, at = np.zeros(len(speed)), list(active)
            impulse[at] = -self.solvers[active] @ speed[at]
            after = speed + self.delassus @ impulse
            if (impulse >= -small).all() and all(after[i] >= -small for i in closed):
                self.last = active
                return impulse
        raise AssertionError("no impulses meet the law of impact")

    def rocking(self, side):
        """Return the rates of q for a unit rate of u while it rocks to this side, as the contacts say."""
        pivots = [1, 2] if side > 0 else [0, 3]  # foot and hinge: right and left, or left and right
        motion = null_space(np.array([*self.held, *self.gaps[pivots], *self.gaps[4:]]))[:, 0]
        return motion / (self.hinge @ motion)

    def after_impact(self, restitution=0.0):
        """Return the rates of q after the impact of a wall that falls to u = 0 at a unit rate, all contacts closed."""
        before = -self.rocking(1)
        speed = self.gaps @ before
        impulse = self.impulses(
            (1 + restitution) * np.minimum(speed, 0) + np.maximum(speed, 0), {*range(len(speed))}
        )
        return before + self.free @ self.inverse @ self.lift.T @ impulse

    def peaks(self, release, h, count, restitution=0.0):
        """Release the wall at u; return peaks of u [m], and the largest opening of all contacts at once [m].

        `fall` is then the time to the first u = 0. [s]
        """
        q, s = release * self.rocking(1), np.zeros(len(self.inverse))
        u, peaks, apart, before, steps, self.fall = release, [release], 0.0, 0.0, 0, 0.0
        while len(peaks) <= count:
            q_half = q + h / 2 * (self.free @ s)
            closed = set(np.flatnonzero(self.gaps @ q_half <= 1e-12).tolist())
            load = self.free.T @ (self.force + self.push @ q_half)
            freely = s + h * (self.inverse @ load)
            speed = self.lift @ freely + restitution * np.minimum(self.lift @ s, 0)
            s = freely + self.inverse @ (self.lift.T @ self.impulses(speed, closed))
            q = q_half + h / 2 * (self.free @ s)
            gaps = self.gaps @ q
            apart = max(apart, min(gaps[:2].max(), gaps[:2].min()), gaps[2:4].min())
            passed, u, rate = u, self.hinge @ q, self.hinge @ (self.free @ s)
            steps += 1
            if passed > 0 >= u and self.fall == 0.0:
                self.fall = h * (steps - u / (u - passed))
            if before * rate < 0 and u * before > 0:
                peaks.append(abs(u))
            before = rate
        return np.array(peaks), apart

    def followed(self, release, h, base, apart):
        """Release the wall at u while its supports move; return u from their line at the end of each step [m].

        `base` is the acceleration of the base in the middle of each step [m s-2], `apart` the displacement, velocity
        and acceleration of the top relative to it, at the middles and ends of the steps, shape (3, 2, steps).
        """
        q, s = self.free.T @ (release * self.rocking(1)), np.zeros(len(self.inverse))
        found, lifts = [], self.gaps @ self.tilted
        for ground, middle, end in zip(base, *apart.transpose(1, 2, 0), strict=True):
            q_half = q + h / 2 * s
            full = self.free @ q_half + self.tilted * middle[0]
            closed = set(np.flatnonzero(self.gaps @ full <= 1e-12).tolist())
            inertia = self.sideways * ground + self.mass @ self.tilted * middle[2]
            freely = s + h * (
                self.inverse @ (self.free.T @ (self.force + self.sinking @ full - inertia))
            )
            s = freely + self.inverse @ (
                self.lift.T @ self.impulses(self.lift @ freely + lifts * end[1], closed)
            )
            q = q_half + h / 2 * s
            found.append(self.hinge @ (self.free @ q))
        return np.array(found)
