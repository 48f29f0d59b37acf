"""Two rigid bodies on contacts, in small rotations: Moreau's time stepping with Newton's law.

Nothing of the mechanism is put in: each body has x, y and a rotation, corners may lift and land,
faces do not slide, and the supports hold their points. Hinges, strength and restitution come out.
A part of the overburden that has a mass is a third body, which moves up and down and lies on the
head; it may lift off.
"""

from itertools import combinations

import numpy as np
from scipy.linalg import null_space

GRAVITY = 9.80665  # [m s-2]
CLOSED = 1e-12  # largest gap of a closed contact [m]


class TwoBodiesOnContacts:
    """Coordinates q = (x1, y1, theta1, x2, y2, theta2, y3) from the upright wall.

    The rotations are anticlockwise; y3 is that of the mass on top, if there is one.
    """

    def __init__(self, wall):
        t = float(wall.thickness)
        h1 = float(wall.lower_height)
        h2 = float(wall.upper_height)
        h = h1 + h2
        masses = float(wall.mass) * np.array([h1, h2]) / h
        turning = masses * (t**2 + np.array([h1, h2]) ** 2) / 12
        overburden = float(wall.overburden)
        lying = float(wall.overburden_mass) * overburden  # the weight of the mass on top [N]
        diagonal = [masses[0], masses[0], turning[0], masses[1], masses[1], turning[1]]
        if lying:
            diagonal.append(lying / GRAVITY)
        self.mass = np.diag(diagonal)
        self._place_contacts(t, h1, h2, has_slab=bool(lying))
        weights = GRAVITY * masses
        self.force = -weights[0] * self._centre_rise(0) - weights[1] * self._centre_rise(1)
        self.force = self.force - (overburden - lying) * self.head[1]
        if lying:
            self.force = self.force - lying * self._slab_rise()
        # Weights and overburden rise less at larger rotations: half of K0, as u carries half of the
        # mass.
        self.push = float(wall.rigid_stiffness) / 2 * np.outer(self.hinge, self.hinge)
        self._invert_contacts()
        # A displacement of one of the top: both bodies lie along the tilted line of the supports.
        self.tilted = np.zeros(len(self.mass))
        self.tilted[:6] = h1 / 2 / h, 0, -1 / h, (h1 + h2 / 2) / h, 0, -1 / h
        self.sideways = np.zeros(len(self.mass))
        self.sideways[[0, 3]] = masses
        # Gain of potential by the square of the rotation of each body, whatever held it.
        self.sinking = np.zeros(self.mass.shape)
        self.sinking[2, 2] = h1 * (weights[0] / 2 + weights[1] + overburden)
        self.sinking[5, 5] = h2 * (weights[1] / 2 + overburden)

    def _point(self, body, dx, dy):
        """Return the rows of x and y of a body's point, at (dx, dy) from its centre."""
        rows = np.zeros((2, len(self.mass)))
        rows[0, 3 * body : 3 * body + 3] = 1, 0, -dy
        rows[1, 3 * body : 3 * body + 3] = 0, 1, dx
        return rows

    def _centre_rise(self, body):
        return self._point(body, 0, 0)[1]

    def _slab_rise(self):
        row = np.zeros(7)
        row[6] = 1
        return row

    def _place_contacts(self, t, h1, h2, has_slab):
        sides = (-t / 2, t / 2)
        foot = [self._point(0, side, -h1 / 2) for side in sides]
        lower_face = [self._point(0, side, h1 / 2) for side in sides]
        upper_face = [self._point(1, side, -h2 / 2) for side in sides]
        self.head = self._point(1, 0.0, h2 / 2)
        self.hinge = lower_face[0][0]  # x of the hinge, u
        # No sliding at the foot and between the bodies; the head is held sideways and free to rise.
        self.held = np.array([foot[0][0], upper_face[0][0] - lower_face[0][0], self.head[0]])
        gaps = [corner[1] for corner in foot]
        gaps += [upper_face[side][1] - lower_face[side][1] for side in (0, 1)]
        if has_slab:
            gaps.append(self._slab_rise() - self.head[1])
        self.gaps = np.array(gaps)

    def _invert_contacts(self):
        """Invert the inertia, and the contacts of each set that can be active together."""
        self.free = null_space(self.held)  # the motions that slide nowhere
        self.inverse = np.linalg.inv(self.free.T @ self.mass @ self.free)
        self.lift = self.gaps @ self.free
        self.delassus = self.lift @ self.inverse @ self.lift.T
        self.solvers = {}
        for size in range(len(self.inverse) + 1):
            for active in combinations(range(len(self.lift)), size):
                part = self.delassus[np.ix_(active, active)]
                if size == 0:
                    self.solvers[active] = part
                elif np.linalg.cond(part) < 1e10:
                    self.solvers[active] = np.linalg.inv(part)
        self.last = (0, 1, 2)

    def impulses(self, speed, closed):
        """Return P >= 0 of the contacts: w = speed + delassus P >= 0 and w P = 0 where closed.

        Open contacts have P = 0.
        """
        small = 1e-9 * np.abs(speed).max() + 1e-300
        for active in [self.last, *self.solvers]:
            if active not in self.solvers or not set(active) <= closed:
                continue
            members = list(active)
            impulse = np.zeros(len(speed))
            impulse[members] = -self.solvers[active] @ speed[members]
            end_speed = speed + self.delassus @ impulse
            if (impulse >= -small).all() and (end_speed[list(closed)] >= -small).all():
                self.last = active
                return impulse
        raise AssertionError("no impulses meet the law of impact")

    def rocking(self, side):
        """Return the rates of q for a unit rate of u as the wall rocks to a side."""
        pivots = [1, 2] if side > 0 else [0, 3]  # foot and hinge
        closed = np.array([*self.held, *self.gaps[pivots], *self.gaps[4:]])
        motion = null_space(closed)[:, 0]
        return motion / (self.hinge @ motion)

    def after_impact(self, restitution=0.0):
        """Return the rates of q after a fall to u = 0 at a unit rate, with all contacts closed."""
        rates = -self.rocking(1)
        speed = self.gaps @ rates
        approach = (1 + restitution) * np.minimum(speed, 0) + np.maximum(speed, 0)
        impulse = self.impulses(approach, set(range(len(speed))))
        return rates + self.free @ self.inverse @ self.lift.T @ impulse

    def peaks(self, release, step, count, restitution=0.0):
        """Release the wall at u; return peaks of u and the largest opening of all contacts [m].

        Afterwards `fall` is the time to the first u = 0. [s]
        """
        q = release * self.rocking(1)
        s = np.zeros(len(self.inverse))
        u = release
        rate = 0.0
        peaks = [release]
        opening = 0.0
        steps = 0
        self.fall = 0.0
        while len(peaks) <= count:
            q_half = q + step / 2 * (self.free @ s)
            closed = set(np.flatnonzero(self.gaps @ q_half <= CLOSED).tolist())
            load = self.free.T @ (self.force + self.push @ q_half)
            s_free = s + step * (self.inverse @ load)
            speed = self.lift @ s_free + restitution * np.minimum(self.lift @ s, 0)
            s = s_free + self.inverse @ (self.lift.T @ self.impulses(speed, closed))
            q = q_half + step / 2 * (self.free @ s)
            gaps = self.gaps @ q
            opening = max(opening, gaps[:2].min(), gaps[2:4].min())
            last_u, u = u, self.hinge @ q
            last_rate, rate = rate, self.hinge @ (self.free @ s)
            steps += 1
            if last_u > 0 >= u and self.fall == 0.0:
                self.fall = step * (steps - u / (u - last_u))
            if last_rate * rate < 0 and u * last_rate > 0:
                peaks.append(abs(u))
        return np.array(peaks), opening

    def shaken(self, release, step, base, apart):
        """Release the wall at u while its supports move; return u from their line at each step [m].

        `base` is the acceleration of the base in the middle of each step [m s-2]. `apart` has the
        displacement, velocity and acceleration of the top relative to the base, in the middle and
        at the end of each step, shape (3, 2, steps).
        """
        q = self.free.T @ (release * self.rocking(1))
        s = np.zeros(len(self.inverse))
        displacements = []
        tilting = self.gaps @ self.tilted
        for ground, middle, end in zip(base, *apart.transpose(1, 2, 0), strict=True):
            q_half = q + step / 2 * s
            full = self.free @ q_half + self.tilted * middle[0]
            closed = set(np.flatnonzero(self.gaps @ full <= CLOSED).tolist())
            inertia = self.sideways * ground + self.mass @ self.tilted * middle[2]
            load = self.free.T @ (self.force + self.sinking @ full - inertia)
            s_free = s + step * (self.inverse @ load)
            impulse = self.impulses(self.lift @ s_free + tilting * end[1], closed)
            s = s_free + self.inverse @ (self.lift.T @ impulse)
            q = q_half + step / 2 * s
            displacements.append(self.hinge @ (self.free @ q))
        return np.array(displacements)
