"""Walls that rock to one side, against a stop: facades in front of return walls or floors, with or without ties.

The wall moves away from the stop, u >= 0, and hits it at u = 0. F is what works on half of the displacement u, as
lambda m_eff a = m a does, of a wall with a hinge and of a block alike: a force where the displacement is u counts
twice in it.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arguments import instance, number, numbers, real, together
from rockdamp.arrays import Array, ByValue, Quantity
from rockdamp.errors import InputError, require
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.plausibility import warn
from rockdamp.stated import of_tie

AT_THE_DISPLACEMENT = 2.0  # of a force at u, in F, which works on u/2
CONTACT_STIFFNESS = 2500.0  # of the stop that stands for a rigid one, over the first branch's; docs/one-sided.md
CONTACT_STEP = 0.1  # of the solver, times the frequency of the stop
LEAST_RESTITUTION = 1e-3  # that a stop with a damper can have
RIGID = np.inf


# ASSUME: all ties of a wall are one, which never slips; without `rupture` it does not break.
@dataclass(frozen=True, eq=False)
class Tie(ByValue):
    """A tie that holds a wall back: tension only, elastic-plastic, and the stretch by which it yielded stays.

    Parameters
    ----------
    stiffness : float or ndarray
        Of all ties of the wall together. [N m-1]
    strength : float or ndarray
        Force at which they yield. [N]
    gap : float or ndarray
        Their slack: how far they move before they pull. [m]
    rupture : float or ndarray
        Stretch at which they break, the elastic part included; infinite by default. [m]
    height_ratio : float or ndarray
        Displacement of the wall at the tie over u: of a block height of the tie over h, with a hinge that over its
        height. [-]

    Raises
    ------
    InputError
        If a value lies outside its range, or the tie breaks before it yields.

    Examples
    --------
    >>> import rockdamp as rd
    >>> rd.Tie(stiffness=2e6, strength=3e3).yield_stretch.item()
    0.0015
    """

    stiffness: Quantity
    strength: Quantity
    gap: Quantity = 0.0
    rupture: Quantity = RIGID
    height_ratio: Quantity = 1.0

    def __post_init__(self) -> None:
        finite = {f"tie {field.name}": getattr(self, field.name) for field in fields(self) if field.name != "rupture"}
        stiffness, strength, gap, height = together(**finite)
        rupture = _or_infinite("tie rupture", self.rupture)
        require(stiffness > 0, "tie stiffness", stiffness, "greater than 0 [N m-1]")
        require(strength > 0, "tie strength", strength, "greater than 0 [N]; a wall without a tie has none")
        require(gap >= 0, "tie gap", gap, "at least 0 [m]")
        require((height > 0) & (height <= 1), "tie height_ratio", height, "greater than 0 and at most 1")
        allowed = "at least strength/stiffness, the stretch at which the tie yields [m]"
        require(rupture >= strength / stiffness, "tie rupture", rupture, allowed)
        for name, value in zip(finite, (stiffness, strength, gap, height), strict=True):
            object.__setattr__(self, name.removeprefix("tie "), value)
        object.__setattr__(self, "rupture", rupture)

    @property
    def yield_stretch(self) -> Array:
        """Stretch at which the tie yields. [m]"""
        return np.asarray(self.strength / self.stiffness)

    def stretch(self, displacement: ArrayLike) -> Array:
        """Return the stretch where the wall is displaced by u, at most that at which the tie breaks. [m]

        Parameters
        ----------
        displacement : float or ndarray
            u. [m]
        """
        return np.clip(self.height_ratio * np.asarray(displacement) - self.gap, 0.0, self.rupture)


# ASSUME: the stop moves as the base does, and beyond u3 the wall has collapsed whatever a tie would still hold.
@dataclass(frozen=True, eq=False)
class OneSidedWall(ByValue):
    """A wall that rocks to one side, away from a stop: a block about its base corner, or one with a hinge.

    Parameters
    ----------
    mechanism : Wall or Parapet
        A `Parapet` is a block that rocks about its base corner, as a facade does; a `Wall` spans between two
        supports.
    tie : Tie, optional
    stop_stiffness : float or ndarray
        Of the stop where the wall's displacement is u; infinite, by default, for a rigid one. [N m-1]
    initial_strength_ratio : float or ndarray
        f(0+): the force over F0 that a load must exceed before a resting wall moves, at most b1 of its curve. The
        tri-linear curve has 0, a wall of rigid bodies 1. [-]

    Raises
    ------
    InputError
        If a value lies outside its range.

    Examples
    --------
    >>> import rockdamp as rd
    >>> front = rd.OneSidedWall(rd.Parapet(thickness=0.8, height=12), rd.Tie(stiffness=2e6, strength=3e3))
    >>> round(float(front.restitution_rigid), 3)
    0.511
    """

    mechanism: Wall | Parapet
    tie: Tie | None = None
    stop_stiffness: Quantity = RIGID
    initial_strength_ratio: Quantity = 0.0

    def __post_init__(self) -> None:
        instance("mechanism", self.mechanism, Wall, Parapet)
        if self.tie is not None:
            warn(of_tie(instance("tie", self.tie, Tie), self.mechanism.weight))
        stop = _or_infinite("stop_stiffness", self.stop_stiffness)
        require(stop > 0, "stop_stiffness", stop, "greater than 0 [N m-1]")
        initial = numbers("initial_strength_ratio", self.initial_strength_ratio)
        require((initial >= 0) & (initial < 1), "initial_strength_ratio", initial, "at least 0 and less than 1")
        object.__setattr__(self, "stop_stiffness", stop)
        object.__setattr__(self, "initial_strength_ratio", initial)

    @property
    def instability_displacement(self) -> Array:
        """u_ins of the mechanism. [m]"""
        return self.mechanism.instability_displacement

    @property
    def frequency_parameter(self) -> Array:
        """p of the mechanism. [rad s-1]"""
        return self.mechanism.frequency_parameter

    @property
    def load_factor(self) -> Array:
        """Factor from the ground acceleration to the dimensionless load, less than 0: u > 0 is away from the stop, and
        a ground that accelerates towards the stop's side throws the wall off it. [s2 m-1]"""
        return self.mechanism.load_factor

    @property
    def velocity_scale(self) -> Array:
        """p u_ins/lambda. [m s-1]"""
        return self.mechanism.velocity_scale

    @property
    def restitution_rigid(self) -> Array:
        r"""Restitution of a block that hits a return wall, e from 0.41 at h/t = 5 to 0.525 of a slender one. [-]

        .. math:: e = 1.05 \, (1 - \tfrac{3}{2} \sin^2 \alpha)^2 \, |1 - \tfrac{3}{2} \cos^2 \alpha|,
            \qquad \tan \alpha = \frac{t}{h}

        Sorrentino, AlShawa and Decanini (2011), second-hand. It is a block's; a wall with a hinge has none of its own.
        """
        sine2 = 1 / (1 + self.mechanism.slenderness**2)
        return np.asarray(1.05 * (1 - 1.5 * sine2) ** 2 * np.abs(1 - 1.5 * (1 - sine2)))

    def rocking_onset(self, strength_ratio: ArrayLike = 1.0) -> Array:
        """Return the ground acceleration whose static load reaches the plateau, without the tie. [m s-2]

        Parameters
        ----------
        strength_ratio : float or ndarray
            b1 of a cracked wall, broadcasts. [-]
        """
        return self.mechanism.rocking_onset(strength_ratio)

    def force(self, curve: TrilinearCurve) -> OneSidedForce:
        """Return the dimensionless force of the wall and its tie.

        Parameters
        ----------
        curve : TrilinearCurve

        Raises
        ------
        InputError
            If the wall starts to move at more than the plateau's strength, or the stop is softer than the wall.
        """
        stop = AT_THE_DISPLACEMENT * self.stop_stiffness / self.mechanism.rigid_stiffness
        own = curve.initial_stiffness * self.mechanism.rigid_stiffness / AT_THE_DISPLACEMENT
        softer = (
            f"at least {float(np.max(own)):.4g} N/m, the stiffness of the wall's first branch: a stop holds the wall"
        )
        require(stop >= curve.initial_stiffness, "stop_stiffness", self.stop_stiffness, softer)
        if self.tie is None:
            return OneSidedForce(curve, self.initial_strength_ratio, stop_stiffness=stop)
        tie, scale = self.tie, AT_THE_DISPLACEMENT * np.asarray(self.tie.height_ratio)
        reach = tie.height_ratio * self.instability_displacement
        return OneSidedForce(
            curve,
            self.initial_strength_ratio,
            tie_stiffness=scale * tie.height_ratio * tie.stiffness / self.mechanism.rigid_stiffness,
            tie_strength=scale * tie.strength / self.mechanism.rigid_strength,
            tie_gap=tie.gap / reach,
            tie_rupture=tie.rupture / reach,
            stop_stiffness=stop,
        )


def tie_of(
    wall: Wall | Parapet,
    stiffness: tuple[float, bool],
    strength: tuple[float, bool],
    gap: float | None = None,
    height: float | None = None,
    rupture: float | None = None,
) -> Tie:
    """Return the tie of one wall, from a stiffness and a strength of which each says whether it is per metre of wall.

    Parameters
    ----------
    wall : Wall or Parapet
    stiffness, strength : tuple of float and bool
        [N m-1] or [N m-2] per metre, and [N] or [N m-1] per metre.
    gap : float, optional
        Slack; without it none. [m]
    height : float, optional
        Of the tie over the base; by default where u is measured. [m]
    rupture : float, optional
        Stretch at which it breaks; by default it does not. [m]
    """
    level = float(height_of_u(wall))
    height = level if height is None else height
    require(0 < height <= level, "tie height", height, f"greater than 0 and at most {level:g} m, where u is measured")
    k, force = (value * (float(wall.width) if by_metre else 1.0) for value, by_metre in (stiffness, strength))
    return Tie(k, force, gap=gap or 0.0, rupture=RIGID if rupture is None else rupture, height_ratio=height / level)


def height_of_u(wall: Wall | Parapet) -> Array:
    """Return the height at which u is measured, of a wall with a hinge that of the hinge. [m]"""
    return np.asarray(wall.lower_height if isinstance(wall, Wall) else wall.height)


@dataclass(frozen=True, eq=False)
class OneSidedForce(ByValue):
    """What holds the wall back, without dimensions: forces over F0 = K0 u_ins, displacements over u_ins.

    Away from the stop, x > 0, it is the tri-linear curve, whose first branch starts at `initial`, and the tension of
    the tie. Pressed into a stop that gives way, x < 0, the wall leans on it with `initial`.

    Parameters
    ----------
    curve : TrilinearCurve
    initial : float or ndarray
        f(0+), at most b1. [-]
    tie_stiffness, tie_strength, tie_gap, tie_rupture : float or ndarray
        0 for no tie; the last is the stretch at which it breaks. [-]
    stop_stiffness : float or ndarray
        Infinite for a rigid stop. [-]

    Raises
    ------
    InputError
        If the wall starts to move at more than the plateau's strength.
    """

    curve: TrilinearCurve
    initial: Quantity = 0.0
    tie_stiffness: Quantity = 0.0
    tie_strength: Quantity = 0.0
    tie_gap: Quantity = 0.0
    tie_rupture: Quantity = RIGID
    stop_stiffness: Quantity = RIGID

    def __post_init__(self) -> None:
        b1 = self.curve.strength_ratio
        name = "initial_strength_ratio"
        require(np.asarray(self.initial) <= b1, name, self.initial, f"at most b1 of the curve, {np.min(b1):g}")

    def parameters(self) -> tuple[Array, ...]:
        """Return slope and start of the first branch, b1, ks, a1, a2, a3, and the tie's four."""
        _, b1, ks, a1, a2, a3 = self.curve.parameters()
        first = ((b1 - self.initial) / a1, self.initial)
        tie = (self.tie_stiffness, self.tie_strength, self.tie_gap, self.tie_rupture)
        return tuple(np.asarray(value, dtype=float) for value in (*first, b1, ks, a1, a2, a3, *tie))

    def energy(self, x: ArrayLike) -> Array:
        """Return the energy that the curve stores at x >= 0, without the tie. [-]

        Parameters
        ----------
        x : float or ndarray
        """
        z = np.asarray(x, dtype=float)
        a1 = self.curve.yield_displacement_ratio
        inside = np.minimum(z, a1)
        return np.asarray(self.curve.energy(z) + self.initial * (inside - inside**2 / (2 * a1)))


@dataclass(frozen=True, eq=False)
class Stop(ByValue):
    r"""A stop as a spring with a dashpot, C = 2 xi sqrt(kc), that acts while the wall presses on it, x < 0.

    An impact on it takes what restitution takes, at every speed. A stop that may pull is a half cycle of a damped
    oscillator; from one that cannot, the wall parts where spring and dashpot cancel:

    .. math::
        \text{may pull:} \quad \xi = \frac{\delta}{\sqrt{\pi^2 + \delta^2}}, \qquad
        \text{cannot:} \quad \delta = \frac{2 \xi \arccos \xi}{\sqrt{1 - \xi^2}}, \qquad \delta = -\ln e

    (beyond xi = 1, arcosh xi over the root of xi^2 - 1). Anagnostopoulos (1988), doi:10.1002/eqe.4290160311; Schwager
    and Poschel (2007), doi:10.1007/s10035-007-0065-z (both from memory). Exact without a force F that presses the wall
    on the stop; with F/(v sqrt(kc)) = 0.01 an e of 0.5 becomes 0.493.

    Parameters
    ----------
    stiffness : float or ndarray
        kc over K0; infinite for a rigid stop, whose impacts take restitution itself. [-]
    restitution : float or ndarray
        e, in (0, 1]. [-]
    pulls : bool
        Whether it may pull the wall back.

    Raises
    ------
    InputError
        If a value lies outside its range.
    """

    stiffness: Quantity
    restitution: Quantity
    pulls: bool = False

    def __post_init__(self) -> None:
        e = numbers("restitution (e)", self.restitution)
        stiffness = _or_infinite("stiffness of the stop", self.stiffness)
        require((e > 0) & (e <= 1), "restitution (e)", e, "greater than 0 and at most 1")
        require(stiffness > 0, "stiffness of the stop", stiffness, "greater than 0")
        if np.isfinite(stiffness).any():
            allowed = f"at least {LEAST_RESTITUTION:g} of a stop with a dashpot"
            require(e >= LEAST_RESTITUTION, "restitution (e)", e, allowed)
        object.__setattr__(self, "restitution", e)
        object.__setattr__(self, "stiffness", stiffness)

    @property
    def damping_ratio(self) -> Array:
        """xi of the stop's own oscillator. [-]"""
        values = [stop_damping_ratio(e, self.pulls) for e in np.ravel(self.restitution)]
        return np.reshape(values, np.shape(self.restitution))

    @property
    def coefficient(self) -> Array:
        """C, 0 of a rigid stop. [-]"""
        kc = np.asarray(self.stiffness)
        return np.where(np.isfinite(kc), 2 * self.damping_ratio * np.sqrt(np.where(np.isfinite(kc), kc, 0.0)), 0.0)


def stop_damping_ratio(restitution: float, pulls: bool = False) -> float:
    """Return the damping ratio of a stop, on which an impact takes e.

    Parameters
    ----------
    restitution : float
        e. [-]
    pulls : bool
        Whether the stop may pull.

    Examples
    --------
    >>> from rockdamp.mechanics.one_sided import stop_damping_ratio
    >>> [round(stop_damping_ratio(0.5, pulls), 3) for pulls in (True, False)]
    [0.215, 0.255]
    """
    e = number("restitution (e)", restitution)
    if not LEAST_RESTITUTION <= e <= 1:
        raise InputError(f"restitution (e) is {e!r}; it must be at least {LEAST_RESTITUTION:g} and at most 1")
    delta = abs(float(np.log(e)))
    if pulls:
        return delta / float(np.hypot(np.pi, delta))
    from scipy.optimize import brentq  # slow to import, and few walls need it

    # Its loss rises with xi from 0, and as 2 ln(2 xi) far beyond 1.
    return float(brentq(lambda xi: parting_loss(xi) - delta, 0.0, 2.0 / e, xtol=1e-15, rtol=1e-14))


def parting_loss(xi: float) -> float:
    """Return delta = -ln e of an impact on a stop that cannot pull."""
    if abs(xi - 1) < 1e-4:  # the series about 1, where both forms are 0/0
        return 2 * xi * (1 - (xi - 1) / 3 + 2 * (xi - 1) ** 2 / 15)
    if xi < 1:
        return float(2 * xi * np.arccos(xi) / np.sqrt(1 - xi * xi))
    return float(2 * xi * np.arccosh(xi) / np.sqrt(xi * xi - 1))


def _or_infinite(name: str, value: Quantity) -> Array:
    """Return numbers of which some may be infinite."""
    array = real(name, value)
    numbers(name, np.where(np.isposinf(array), 1.0, array))
    return array
