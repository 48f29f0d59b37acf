"""Geometry and weights of a wall, a parapet or a one-sided wall to the constants of its equation of motion."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array, Quantity
from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.errors import Rule, check, check_choice, check_fields, check_type

EXCITATION_FACTOR = 1.5  # lambda, Eq. (4)
SORRENTINO_RATIO = 0.90  # e_exp/e_an for a VSSW, section 4.1
# ASSUME: where tests found the hinge, section 2. Eq. (5) alone has its least at the top of a wall without overburden.
HINGE_RANGE = (0.5, 0.7)
WEAKEST = "weakest"  # in place of a hinge's height: the one at which the wall is weakest

RULES: dict[str, Rule] = {
    "thickness": (lambda t: (t > 0) & (t <= 100), "greater than 0 and at most 100 m"),
    "height": (lambda h: (h > 0) & (h <= 1000), "greater than 0 and at most 1000 m"),
    "width": (lambda width: width > 0, "greater than 0 [m]"),
    "density": (lambda density: density > 0, "greater than 0 [kg m-3]"),
    # Masonry of 1 m, the lightest that carries a floor, is crushed by some 1000 times its weight (20 MPa).
    "overburden_ratio": (
        lambda ratio: (ratio >= 0) & (ratio <= 1000),
        "at least 0 and at most 1000, where masonry is crushed",
    ),
}
HINGE_RULES: dict[str, Rule] = {
    "hinge_ratio": (lambda r: (r > 0) & (r < 1), "greater than 0 and less than 1"),
    "overburden_mass": (
        lambda part: (part >= 0) & (part <= 1),
        "between 0 and 1, the part that moves as a mass",
    ),
}


class _Mechanism:
    """Base of a wall and a parapet: both reduce to F0, K0 and the slender limit's mass and excitation factor."""

    thickness: Quantity
    height: Quantity
    width: Quantity
    density: Quantity
    overburden_ratio: Quantity
    eccentricity: Quantity

    def __post_init__(self) -> None:
        check_fields(self, RULES)
        allowed = "at most half the thickness, either way [m]"
        eccentricity = check(
            "eccentricity", self.eccentricity, lambda d: np.abs(d) <= self.thickness / 2, allowed
        )
        object.__setattr__(self, "eccentricity", eccentricity)

    @property
    def slenderness(self) -> Array:
        """h/t. [-]"""
        return np.divide(self.height, self.thickness)

    @property
    def mass(self) -> Array:
        """Mass of the masonry. [kg]"""
        return np.multiply(
            np.multiply(self.density, self.width), np.multiply(self.thickness, self.height)
        )

    @property
    def weight(self) -> Array:
        """Self-weight W. [N]"""
        return self.mass * STANDARD_GRAVITY

    @property
    def overburden(self) -> Array:
        """Vertical force O on the top. [N]"""
        return np.multiply(self.overburden_ratio, self.weight)

    @property
    def inertia_ratio(self) -> Quantity:
        """How many times larger the inertia is with the mass of the overburden than without it. [-]"""
        return 1.0

    @property
    def effective_mass(self) -> Array:
        """m_eff = 2/3 m, Eq. (2), the limit of slender blocks, times `inertia_ratio`. [kg]"""
        return 2 * self.mass / 3 * self.inertia_ratio

    @property
    def excitation_factor(self) -> Quantity:
        """lambda: lambda m_eff = m, as the supports hold the overburden sideways; 3/2 without its mass, Eq. (4). [-]"""
        return EXCITATION_FACTOR / self.inertia_ratio

    @property
    def rigid_strength(self) -> Array:
        """F0. [N]"""
        raise NotImplementedError

    @property
    def rigid_stiffness(self) -> Array:
        """K0, the bi-linear law's negative stiffness, taken positive. [N m-1]"""
        raise NotImplementedError

    @property
    def instability_displacement(self) -> Array:
        """u_ins = F0/K0, Eq. (6). [m]"""
        return self.rigid_strength / self.rigid_stiffness

    @property
    def frequency_parameter(self) -> Array:
        """p = sqrt(K0/m_eff), which makes time dimensionless: tau = p t. [rad s-1]"""
        return np.sqrt(self.rigid_stiffness / self.effective_mass)

    @property
    def load_factor(self) -> Array:
        """-lambda/(p^2 u_ins), the factor from the ground acceleration to the dimensionless load. [s2 m-1]"""
        return -self.excitation_factor / (
            self.frequency_parameter**2 * self.instability_displacement
        )

    @property
    def velocity_scale(self) -> Array:
        """p u_ins/lambda, which makes a ground velocity dimensionless: PGV over it is the velocity ratio. [m s-1]"""
        return self.frequency_parameter * self.instability_displacement / self.excitation_factor

    def rocking_onset(self, strength_ratio: ArrayLike = 1.0) -> Array:
        """Return the ground acceleration whose static load reaches the strength: b1 F0/(lambda m_eff). [m s-2]

        Parameters
        ----------
        strength_ratio : float or ndarray
            b1 of a cracked wall, broadcasts; 1 is the rigid wall. [-]
        """
        return np.asarray(np.asarray(strength_ratio) / np.abs(self.load_factor))


@dataclass(frozen=True)
class Wall(_Mechanism):
    """Vertically spanning wall: two rigid bodies, supports that move together (Sections 2 and 4.1).

    Quantities may be arrays that broadcast against each other. The displacement u is at the hinge. Height over
    thickness is at least 1, and `restitution_rigid` above 0.

    Parameters
    ----------
    thickness, height : float or ndarray
        t and h. [m]
    width : float or ndarray
        Horizontal width of the wall. [m]
    density : float or ndarray
        Of the masonry. [kg m-3]
    hinge_ratio : float, ndarray or "weakest"
        r = h1/h, in (0, 1); h1 is the height of the lower body. ``"weakest"`` takes `weakest_hinge_ratio`. [-]
    overburden_ratio : float or ndarray
        O/W, >= 0. [-]
    eccentricity : float or ndarray
        Of the overburden from mid-thickness, positive towards the top contact corner; reverses with u. [m]
    overburden_mass : float or ndarray
        Part of the overburden, 0 to 1, that moves up and down with the top as a mass; the rest is a force. The floor
        holds it sideways. It makes the wall slower, by its inertia at u = 0, and leaves e as it is. [-]

    Examples
    --------
    >>> import rockdamp as rd
    >>> wall = rd.Wall(thickness=0.3, height=4.5)
    >>> round(float(wall.instability_displacement), 4)  # without overburden the thickness itself
    0.3
    >>> rd.Wall(thickness=0.3, height=[3.0, 4.5]).slenderness
    array([10., 15.])
    >>> round(
    ...     float(
    ...         rd.Wall(
    ...             thickness=0.3, height=4.5, overburden_ratio=2.0, hinge_ratio="weakest"
    ...         ).hinge_ratio
    ...     ),
    ...     3,
    ... )
    0.634
    """

    thickness: Quantity
    height: Quantity
    _: KW_ONLY  # the third would be a width, an overburden or a hinge to different readers
    width: Quantity = 1.0
    density: Quantity = 1800.0
    hinge_ratio: Quantity = 0.7
    overburden_ratio: Quantity = 0.0
    eccentricity: Quantity = 0.0
    overburden_mass: Quantity = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.hinge_ratio, str):
            check_choice("hinge_ratio", self.hinge_ratio, (WEAKEST,))
            object.__setattr__(self, "hinge_ratio", self.weakest_hinge_ratio)
        check_fields(self, HINGE_RULES)
        check("height over thickness", self.slenderness, lambda ratio: ratio >= 1, "at least 1")
        check(
            "restitution by Eq. (7)",
            self.restitution_rigid,
            lambda e: e > 0,
            "above 0: the wall is too squat",
        )

    @property
    def weakest_hinge_ratio(self) -> Array:
        r"""r = h1/h at which F0 of Eq. (5) is least, within 0.5 to 0.7. [-]

        .. math:: \frac{1 - r}{r} = \sqrt{\frac{\Psi \, (1 + 2 d/t)}{2 \, (1 + \Psi)}}, \qquad \Psi = \frac{O}{W}
        """
        t, psi, d = self.thickness, self.overburden_ratio, self.eccentricity
        upper_over_lower = np.sqrt(np.maximum(psi * (1 + 2 * d / t) / (2 * (1 + psi)), 0.0))
        return np.clip(1 / (1 + upper_over_lower), *HINGE_RANGE)

    @property
    def lower_height(self) -> Array:
        """h1, the height of the hinge. [m]"""
        return np.multiply(self.hinge_ratio, self.height)

    @property
    def upper_height(self) -> Array:
        """h2 = h - h1. [m]"""
        return self.height - self.lower_height

    @property
    def rigid_strength(self) -> Array:
        r"""Strength of the rigid wall, Eq. (5), with the overburden O at the eccentricity d. [N]

        .. math:: F_0 = \frac{2 \, (W + O) \, t}{h_1} + \frac{O \, (t + 2 d)}{h_2}
        """
        t, d = self.thickness, self.eccentricity
        own = 2 * (self.weight + self.overburden) * t / self.lower_height
        return own + self.overburden * (t + 2 * d) / self.upper_height

    @property
    def rigid_stiffness(self) -> Array:
        r"""Negative stiffness of the rigid wall, taken positive: the denominator of Eq. (6). [N m-1]

        .. math:: K_0 = \frac{2 \, (W + O)}{h_1} + \frac{2 \, O}{h_2}
        """
        return (
            2 * (self.weight + self.overburden) / self.lower_height
            + 2 * self.overburden / self.upper_height
        )

    @property
    def restitution_rigid(self) -> Array:
        r"""Restitution that keeps the total angular momentum about the new base pivot, Eq. (7). [-]

        .. math:: e_\mathrm{an} = \frac{h_1 (h_1 + h) - 3 t^2}{h_1 (h_1 + h) + 3 t^2}

        It ignores the top support's impulse, which rigid bodies on contacts have: theirs is `restitution_impulsive`.
        Tests measured less than Eq. (7) too: `restitution_measured`.
        """
        product = self.lower_height * (self.lower_height + self.height)
        return (product - 3 * np.square(self.thickness)) / (product + 3 * np.square(self.thickness))

    @property
    def restitution_impulsive(self) -> Array:
        r"""Restitution with the impulse of every support, for r = h1/h and q = t^2/h^2. [-]

        .. math:: e = \frac{2 r^2 (1 - r) - (6 - 5 r) \, q}{2 \, (r^2 (1 - r) + (3 - 2 r) \, q)} \geq 0

        The momentum before the impact is projected on the motion that is admissible after it (docs/theory.md, section
        1). Rigid bodies on contacts with Newton's law of impact lose as much, by time stepping. At 0 the wall stops at
        the impact. NaN where part of the overburden is a mass: no test supports what it would do to e.
        """
        r, q = self.hinge_ratio, 1 / self.slenderness**2
        moving = self.overburden_mass * self.overburden_ratio > 0
        e = np.maximum((2 * r**2 * (1 - r) - (6 - 5 * r) * q) / (2 * self._bodies_inertia), 0.0)
        return np.where(moving, np.nan, e)

    @property
    def restitution_measured(self) -> Array:
        """0.90 of Eq. (7), as section 4.1 has it; the tests that it quotes have 0.86 in the mean, 0.91 at most. [-]"""
        return SORRENTINO_RATIO * self.restitution_rigid

    @property
    def inertia_ratio(self) -> Array:
        r"""How many times larger the inertia is with the mass of the overburden than without it. [-]

        .. math:: 1 + \frac{\psi c^2}{H + U}, \qquad
                  c = \frac{t}{h} \left(\frac{1}{r} + \frac{1/2 + d/t}{1 - r}\right)

        The mass psi m rises by c for each unit of u, with the overburden's eccentricity d; H + U is what the bodies'
        own motions, sideways and up, have of their mass m (docs/theory.md, section 1). All are taken at u = 0.
        """
        r, q = self.hinge_ratio, 1 / self.slenderness**2
        rise = 1 / r + (0.5 + self.eccentricity / self.thickness) / (1 - r)  # c over t/h
        psi = self.overburden_mass * self.overburden_ratio
        return 1 + 3 * r**2 * (1 - r) * psi * q * rise**2 / self._bodies_inertia

    @property
    def _bodies_inertia(self) -> Array:
        """H + U times 3 r^2 (1 - r). [-]"""
        r, q = self.hinge_ratio, 1 / self.slenderness**2
        return np.asarray(r**2 * (1 - r) + (3 - 2 * r) * q)


@dataclass(frozen=True)
class Parapet(_Mechanism):
    """One block that rocks on its base, such as a parapet. The displacement u is at its top.

    Quantities may be arrays that broadcast against each other. `restitution_rigid` is above 0.

    Parameters
    ----------
    thickness, height : float or ndarray
        t and h. [m]
    width : float or ndarray
        Length of the parapet. [m]
    density : float or ndarray
        Of the masonry. [kg m-3]
    overburden_ratio : float or ndarray
        O/W, >= 0. [-]
    eccentricity : float or ndarray
        Of the overburden from mid-thickness, positive towards the top contact corner; reverses with u. [m]

    Examples
    --------
    >>> import rockdamp as rd
    >>> parapet = rd.Parapet(thickness=0.3, height=1.5)
    >>> round(float(parapet.restitution_rigid), 3)
    0.942
    """

    thickness: Quantity
    height: Quantity
    _: KW_ONLY
    width: Quantity = 1.0
    density: Quantity = 1800.0
    overburden_ratio: Quantity = 0.0
    eccentricity: Quantity = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        check(
            "restitution by Housner",
            self.restitution_rigid,
            lambda e: e > 0,
            "above 0: the block is too squat",
        )

    @property
    def rigid_strength(self) -> Array:
        r"""Strength of the rigid parapet, with the overburden O at the eccentricity d. [N]

        .. math:: F_0 = \frac{W t + O \, (t + 2 d)}{h}
        """
        t, d = self.thickness, self.eccentricity
        return (self.weight * t + self.overburden * (t + 2 * d)) / self.height

    @property
    def rigid_stiffness(self) -> Array:
        r"""Negative stiffness of the rigid parapet, taken positive. [N m-1]

        .. math:: K_0 = \frac{W + 2 \, O}{h}
        """
        return (self.weight + 2 * self.overburden) / self.height

    @property
    def restitution_rigid(self) -> Array:
        r"""Housner's restitution of one block (doi:10.1785/BSSA0530020403). [-]

        .. math:: e = 1 - \frac{3}{2} \sin^2 \alpha, \qquad \tan \alpha = \frac{t}{h}
        """
        return 1 - 1.5 / (1 + self.slenderness**2)

    @property
    def restitution_impulsive(self) -> Array:
        """Equal to `restitution_rigid`: with one body and one contact the two principles coincide. [-]"""
        return self.restitution_rigid

    @property
    def restitution_measured(self) -> Array:
        """Equal to `restitution_rigid`: the tests of section 4.1 are of walls with two bodies. [-]"""
        return self.restitution_rigid


# ASSUME: the stop is rigid and moves as the base does.
@dataclass(frozen=True)
class OneSidedWall:
    """A wall that rocks to one side, away from a rigid stop: u >= 0, and an impact turns v into -e v.

    Its sizes are those of its mechanism. `load_factor` is less than 0: a ground that accelerates towards the stop's
    side throws the wall off it.

    Parameters
    ----------
    mechanism : Wall or Parapet
        A `Parapet` is a block that rocks about its base corner, as a facade does; a `Wall` spans between two
        supports.

    Examples
    --------
    >>> import rockdamp as rd
    >>> front = rd.OneSidedWall(rd.Parapet(thickness=0.8, height=12))
    >>> round(float(front.restitution_measured), 3)
    0.511
    """

    mechanism: Wall | Parapet

    def __post_init__(self) -> None:
        check_type("mechanism", self.mechanism, Wall, Parapet)

    @property
    def instability_displacement(self) -> Array:
        """u_ins. [m]"""
        return self.mechanism.instability_displacement

    @property
    def frequency_parameter(self) -> Array:
        """p. [rad s-1]"""
        return self.mechanism.frequency_parameter

    @property
    def load_factor(self) -> Array:
        """Factor from the ground acceleration to the dimensionless load. [s2 m-1]"""
        return self.mechanism.load_factor

    @property
    def velocity_scale(self) -> Array:
        """p u_ins/lambda. [m s-1]"""
        return self.mechanism.velocity_scale

    @property
    def restitution_measured(self) -> Array:
        r"""Restitution of a block that hits a return wall: 0.41 at h/t = 5, 0.525 of a slender one. [-]

        .. math:: e = 1.05 \, (1 - \tfrac{3}{2} \sin^2 \alpha)^2 \, |1 - \tfrac{3}{2} \cos^2 \alpha|,
            \qquad \tan \alpha = \frac{t}{h}

        Sorrentino, AlShawa and Decanini (2011), second-hand. A wall with a hinge has none.
        """
        sine2 = 1 / (1 + self.mechanism.slenderness**2)
        return np.asarray(1.05 * (1 - 1.5 * sine2) ** 2 * np.abs(1 - 1.5 * (1 - sine2)))

    def rocking_onset(self, strength_ratio: ArrayLike = 1.0) -> Array:
        """Return the ground acceleration whose static load reaches the plateau. [m s-2]

        Parameters
        ----------
        strength_ratio : float or ndarray
            b1 of a cracked wall, broadcasts. [-]
        """
        return self.mechanism.rocking_onset(strength_ratio)
