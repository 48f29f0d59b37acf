"""Sizes and weights of walls, and the constants of their equation of motion."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array, Quantity, short_repr
from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.errors import Rule, check, check_choice, check_fields, check_type

EXCITATION_FACTOR = 1.5  # lambda, Eq. (4)
SORRENTINO_RATIO = 0.90  # e measured over e of Eq. (7), section 4.1
# ASSUME: where tests found the hinge, section 2. Without these bounds F0 of Eq. (5) would be least
# with the hinge at the top, for a wall without overburden.
HINGE_RANGE = (0.5, 0.7)

MECHANISM_RULES: dict[str, Rule] = {
    "thickness": (
        lambda t: (t > 0) & (t <= 100),
        "greater than 0 and at most 100 m; 250 mm is 0.25 m",
    ),
    "height": (lambda h: (h > 0) & (h <= 1000), "greater than 0 and at most 1000 m"),
    "width": (lambda width: width > 0, "greater than 0 [m]"),
    "density": (lambda density: density > 0, "greater than 0 [kg m-3]"),
    # Masonry 1 m high is the lightest that carries a floor. About 1000 times its weight crushes it:
    # 20 MPa.
    "overburden_ratio": (
        lambda ratio: (ratio >= 0) & (ratio <= 1000),
        "at least 0 and at most 1000, where masonry is crushed",
    ),
    "own_inertia": (lambda choice: (choice == 0) | (choice == 1), "True or False"),
}
HINGE_RULES: dict[str, Rule] = {
    "hinge_ratio": (lambda r: (r > 0) & (r < 1), "greater than 0 and less than 1"),
    "overburden_mass": (
        lambda part: (part >= 0) & (part <= 1),
        "between 0 and 1, the part that moves as a mass",
    ),
}


class _Mechanism:
    """Base of `Wall` and `Parapet`: both reduce to F0, K0, m_eff and lambda."""

    thickness: Quantity
    height: Quantity
    width: Quantity
    density: Quantity
    overburden_ratio: Quantity
    eccentricity: Quantity
    own_inertia: Quantity

    def __post_init__(self) -> None:
        check_fields(self, MECHANISM_RULES)
        largest = self.thickness / 2
        eccentricity = check(
            "eccentricity",
            self.eccentricity,
            lambda d: np.abs(d) <= largest,
            "from -t/2 to t/2 [m]",
        )
        object.__setattr__(self, "eccentricity", eccentricity)
        object.__setattr__(self, "own_inertia", self.own_inertia.astype(bool))

    __repr__ = short_repr

    @property
    def slenderness(self) -> Array:
        """Slenderness h/t. [-]"""
        return np.divide(self.height, self.thickness)

    @property
    def mass(self) -> Array:
        """Mass m of the masonry. [kg]"""
        mass_per_area = np.multiply(self.density, self.width)
        return np.multiply(mass_per_area, np.multiply(self.thickness, self.height))

    @property
    def weight(self) -> Array:
        """Self-weight W. [N]"""
        return self.mass * STANDARD_GRAVITY

    @property
    def overburden(self) -> Array:
        """Vertical force O on the top. [N]"""
        return np.multiply(self.overburden_ratio, self.weight)

    @property
    def inertia_ratio(self) -> Array:
        """Effective mass divided by 2/3 m, the effective mass of slender blocks. [-]"""
        raise NotImplementedError

    @property
    def effective_mass(self) -> Array:
        """Effective mass m_eff: 2/3 m, Eq. (2), times `inertia_ratio`. [kg]"""
        return 2 * self.mass / 3 * self.inertia_ratio

    @property
    def excitation_factor(self) -> Array:
        """Excitation factor lambda = m/m_eff: 3/2, Eq. (4), over `inertia_ratio`. [-]"""
        return EXCITATION_FACTOR / self.inertia_ratio

    @property
    def rigid_strength(self) -> Array:
        """Strength F0 of the rigid mechanism. [N]"""
        raise NotImplementedError

    @property
    def rigid_stiffness(self) -> Array:
        """Stiffness K0 of the rigid mechanism, which is negative, as a positive number. [N m-1]"""
        raise NotImplementedError

    @property
    def instability_displacement(self) -> Array:
        """Displacement u_ins = F0/K0 at which the rigid mechanism has no strength, Eq. (6). [m]"""
        return self.rigid_strength / self.rigid_stiffness

    @property
    def frequency_parameter(self) -> Array:
        """Frequency p = sqrt(K0/m_eff); the dimensionless time is tau = p t. [rad s-1]"""
        return np.sqrt(self.rigid_stiffness / self.effective_mass)

    @property
    def load_factor(self) -> Array:
        """Factor -lambda/(p^2 u_ins) from ground acceleration to dimensionless load. [s2 m-1]"""
        scale = self.frequency_parameter**2 * self.instability_displacement
        return -self.excitation_factor / scale

    @property
    def velocity_scale(self) -> Array:
        """Ground velocity p u_ins/lambda: the velocity ratio is PGV divided by it. [m s-1]"""
        return self.frequency_parameter * self.instability_displacement / self.excitation_factor

    def rocking_onset(self, strength_ratio: ArrayLike = 1.0) -> Array:
        """Return the ground acceleration b1 F0/m whose static load reaches the strength. [m s-2]

        Parameters
        ----------
        strength_ratio : float or ndarray
            Strength b1 of the cracked wall divided by F0, 1 for the rigid wall; broadcasts. [-]
        """
        return np.asarray(np.asarray(strength_ratio) / np.abs(self.load_factor))


@dataclass(frozen=True, repr=False)
class Wall(_Mechanism):
    """Vertically spanning wall: two rigid bodies between supports that move together.

    See sections 2 and 4.1 of the paper. The displacement u is that of the hinge. All quantities may
    be arrays that broadcast against each other.

    Parameters
    ----------
    thickness : float or ndarray
        Thickness t, at most the height. [m]
    height : float or ndarray
        Height h between the supports. [m]
    width : float or ndarray
        Horizontal length of the wall. The default is 1. [m]
    density : float or ndarray
        Density of the masonry. The default is 1800. [kg m-3]
    hinge_ratio : float, ndarray or "weakest"
        Relative height of the hinge, r = h1/h, between 0 and 1; ``"weakest"`` for
        `weakest_hinge_ratio`. The default is 0.7. [-]
    overburden_ratio : float or ndarray
        Vertical force on the top divided by the weight of the wall, O/W, from 0 to 1000. The
        default is 0. [-]
    eccentricity : float or ndarray
        Distance of the overburden from mid-thickness, from -t/2 to t/2, positive where it raises
        the strength: towards the corner about which the top turns. It changes side with u. The
        default is 0. [m]
    overburden_mass : float or ndarray
        Part of the overburden, from 0 to 1, that is a mass and moves up and down with the top; the
        rest is a force alone. The floor holds the mass horizontally. The mass makes the wall slower
        and does not change e. The default is 0. [-]
    own_inertia : bool or ndarray of bool
        False for the effective mass of slender blocks, 2/3 m, as in the paper. True adds the
        inertia of the bodies' thickness: their rotation, and their rise and fall as they rock.
        `inertia_ratio` gives the formula.

    Raises
    ------
    InputError
        If a quantity is outside its range, h/t is less than 1, or the wall is so squat that e of
        Eq. (7) is not above 0.

    Examples
    --------
    >>> import rockdamp as rd
    >>> wall = rd.Wall(thickness=0.3, height=4.5)
    >>> wall
    Wall(thickness=0.3, height=4.5)
    >>> round(float(wall.instability_displacement), 4)  # the thickness: there is no overburden
    0.3
    >>> rd.Wall(thickness=0.3, height=[3.0, 4.5]).slenderness
    array([10., 15.])
    >>> loaded = rd.Wall(thickness=0.3, height=4.5, overburden_ratio=2.0, hinge_ratio="weakest")
    >>> round(float(loaded.hinge_ratio), 3)
    0.634
    """

    thickness: Quantity
    height: Quantity
    _: KW_ONLY  # readers would take a third position for the width, the overburden or the hinge
    width: Quantity = 1.0
    density: Quantity = 1800.0
    hinge_ratio: Quantity = 0.7
    overburden_ratio: Quantity = 0.0
    eccentricity: Quantity = 0.0
    overburden_mass: Quantity = 0.0
    own_inertia: Quantity = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.hinge_ratio, str):
            check_choice("hinge_ratio", self.hinge_ratio, ("weakest",))
            object.__setattr__(self, "hinge_ratio", self.weakest_hinge_ratio)
        check_fields(self, HINGE_RULES)
        check("height over thickness", self.slenderness, lambda ratio: ratio >= 1, "at least 1")
        allowed = "above 0: the wall is too squat"
        check("restitution by Eq. (7)", self.restitution_rigid, lambda e: e > 0, allowed)

    @property
    def weakest_hinge_ratio(self) -> Array:
        r"""Ratio r = h1/h within 0.5 to 0.7 for which F0 of Eq. (5) is smallest. [-]

        .. math:: \frac{1 - r}{r} = \sqrt{\frac{\Psi \, (1 + 2 d/t)}{2 \, (1 + \Psi)}}, \qquad
            \Psi = \frac{O}{W}
        """
        t, psi, d = self.thickness, self.overburden_ratio, self.eccentricity
        square = psi * (1 + 2 * d / t) / (2 * (1 + psi))
        upper_over_lower = np.sqrt(np.maximum(square, 0.0))  # rounding may put it below 0
        return np.clip(1 / (1 + upper_over_lower), *HINGE_RANGE)

    @property
    def lower_height(self) -> Array:
        """Height h1 of the lower body. [m]"""
        return np.multiply(self.hinge_ratio, self.height)

    @property
    def upper_height(self) -> Array:
        """Height h2 = h - h1 of the upper body. [m]"""
        return self.height - self.lower_height

    @property
    def rigid_strength(self) -> Array:
        r"""Strength of the rigid wall, Eq. (5), with the overburden O at the eccentricity d. [N]

        .. math:: F_0 = \frac{2 \, (W + O) \, t}{h_1} + \frac{O \, (t + 2 d)}{h_2}
        """
        t, d = self.thickness, self.eccentricity
        lower = 2 * (self.weight + self.overburden) * t / self.lower_height
        return lower + self.overburden * (t + 2 * d) / self.upper_height

    @property
    def rigid_stiffness(self) -> Array:
        r"""Stiffness of the rigid wall, which is negative, as a positive number. [N m-1]

        It is the denominator of Eq. (6).

        .. math:: K_0 = \frac{2 \, (W + O)}{h_1} + \frac{2 \, O}{h_2}
        """
        lower = 2 * (self.weight + self.overburden) / self.lower_height
        return lower + 2 * self.overburden / self.upper_height

    @property
    def restitution_rigid(self) -> Array:
        r"""Restitution that conserves the angular momentum about the new base pivot, Eq. (7). [-]

        .. math:: e_\mathrm{an} = \frac{h_1 (h_1 + h) - 3 t^2}{h_1 (h_1 + h) + 3 t^2}

        It ignores the impulse of the top support, which `restitution_impulsive` includes. Tests
        gave less than Eq. (7): see `restitution_measured`.
        """
        product = self.lower_height * (self.lower_height + self.height)
        square = 3 * np.square(self.thickness)
        return (product - square) / (product + square)

    @property
    def restitution_impulsive(self) -> Array:
        r"""Restitution with the impulses of all supports, for r = h1/h and q = t^2/h^2. [-]

        .. math::
            e = \frac{2 r^2 (1 - r) - (6 - 5 r) \, q}{2 \, (r^2 (1 - r) + (3 - 2 r) \, q)} \geq 0

        The momentum before the impact is projected onto the admissible motion after it
        (docs/theory.md, section 1). Rigid bodies on contacts with Newton's law of impact lose as
        much. At e = 0 the wall stops at the impact. NaN if part of the overburden has mass, whose
        effect on e no test shows.
        """
        r = self.hinge_ratio
        q = 1 / self.slenderness**2
        numerator = 2 * r**2 * (1 - r) - (6 - 5 * r) * q
        e = np.maximum(numerator / (2 * self._scaled_inertia), 0.0)
        has_mass = self.overburden_mass * self.overburden_ratio > 0
        return np.where(has_mass, np.nan, e)

    @property
    def restitution_measured(self) -> Array:
        """Restitution of tests, section 4.1: 0.90 times Eq. (7). [-]

        The tests quoted there gave 0.86 times Eq. (7) on average and 0.91 times at most.
        """
        return SORRENTINO_RATIO * self.restitution_rigid

    @property
    def inertia_ratio(self) -> Array:
        r"""Effective mass divided by 2/3 m, the effective mass of slender blocks. [-]

        .. math:: B \left(1 + \frac{3 \psi c^2}{B}\right), \qquad
            B = 1 + \frac{3 - 2 r}{r^2 (1 - r)} \, \frac{t^2}{h^2}, \qquad
            c = \frac{t}{h} \left(\frac{1}{r} + \frac{1/2 + d/t}{1 - r}\right)

        B is that of the bodies alone. The mass psi m of the overburden rises by c for each unit of
        u (docs/theory.md, section 1). Without `own_inertia` the first factor is 1, the limit of
        slender blocks.
        """
        r = self.hinge_ratio
        q = 1 / self.slenderness**2
        bodies = np.where(self.own_inertia, self._scaled_inertia / (r**2 * (1 - r)), 1.0)
        psi = self.overburden_mass * self.overburden_ratio
        rise = 1 / r + (0.5 + self.eccentricity / self.thickness) / (1 - r)  # c over t/h
        return bodies * (1 + 3 * r**2 * (1 - r) * psi * q * rise**2 / self._scaled_inertia)

    @property
    def _scaled_inertia(self) -> Array:
        """Inertia ratio B of the bodies alone times r^2 (1 - r). [-]"""
        r = self.hinge_ratio
        q = 1 / self.slenderness**2
        return np.asarray(r**2 * (1 - r) + (3 - 2 * r) * q)


@dataclass(frozen=True, repr=False)
class Parapet(_Mechanism):
    """One rigid block that rocks on its base, such as a parapet.

    The displacement u is that of the top. All quantities may be arrays that broadcast against each
    other.

    Parameters
    ----------
    thickness : float or ndarray
        Thickness t. [m]
    height : float or ndarray
        Height h. [m]
    width : float or ndarray
        Horizontal length of the parapet. The default is 1. [m]
    density : float or ndarray
        Density of the masonry. The default is 1800. [kg m-3]
    overburden_ratio : float or ndarray
        Vertical force on the top divided by the weight of the parapet, O/W, from 0 to 1000. The
        default is 0. [-]
    eccentricity : float or ndarray
        Distance of the overburden from mid-thickness, from -t/2 to t/2, positive where it raises
        the strength: towards the corner about which the top turns. It changes side with u. The
        default is 0. [m]
    own_inertia : bool or ndarray of bool
        False for the effective mass of a slender block, 2/3 m, as in the paper. True for that of a
        block of finite thickness, 2/3 m (1 + (t/h)^2).

    Raises
    ------
    InputError
        If a quantity is outside its range, or the block is so squat that Housner's e is not above
        0.

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
    own_inertia: Quantity = False

    def __post_init__(self) -> None:
        super().__post_init__()
        allowed = "above 0: the block is too squat"
        check("restitution by Housner", self.restitution_rigid, lambda e: e > 0, allowed)

    @property
    def rigid_strength(self) -> Array:
        r"""Strength of the rigid parapet, with the overburden O at the eccentricity d. [N]

        .. math:: F_0 = \frac{W t + O \, (t + 2 d)}{h}
        """
        t, d = self.thickness, self.eccentricity
        return (self.weight * t + self.overburden * (t + 2 * d)) / self.height

    @property
    def rigid_stiffness(self) -> Array:
        r"""Stiffness of the rigid parapet, which is negative, as a positive number. [N m-1]

        .. math:: K_0 = \frac{W + 2 \, O}{h}
        """
        return (self.weight + 2 * self.overburden) / self.height

    @property
    def inertia_ratio(self) -> Array:
        r"""Effective mass divided by 2/3 m, the effective mass of slender blocks. [-]

        .. math:: 1 + \frac{t^2}{h^2}

        This holds for a block that turns about its corner. Without `own_inertia` the ratio is 1.
        """
        return np.where(self.own_inertia, 1 + 1 / self.slenderness**2, 1.0)

    @property
    def restitution_rigid(self) -> Array:
        r"""Housner's restitution of one block (doi:10.1785/BSSA0530020403). [-]

        .. math:: e = 1 - \frac{3}{2} \sin^2 \alpha, \qquad \tan \alpha = \frac{t}{h}
        """
        return 1 - 1.5 / (1 + self.slenderness**2)

    @property
    def restitution_impulsive(self) -> Array:
        """Equal to `restitution_rigid`: a single contact has no further impulse. [-]"""
        return self.restitution_rigid

    @property
    def restitution_measured(self) -> Array:
        """Equal to `restitution_rigid`: the tests of section 4.1 have two bodies. [-]"""
        return self.restitution_rigid


# ASSUME: the stop is rigid and moves as the base does.
@dataclass(frozen=True, repr=False)
class OneSidedWall:
    """Wall that rocks to one side, away from a rigid stop.

    Its u is never less than 0, and an impact turns the velocity v into -e v. A ground acceleration
    towards the stop pushes the wall off it: `load_factor` is negative.

    Parameters
    ----------
    mechanism : Wall or Parapet
        Sizes and weights. A `Parapet` is a block that rocks about a corner of its base, as a facade
        does; a `Wall` spans between two supports.

    Examples
    --------
    >>> import rockdamp as rd
    >>> front = rd.OneSidedWall(rd.Parapet(thickness=0.8, height=12))
    >>> front
    OneSidedWall(mechanism=Parapet(thickness=0.8, height=12.0))
    >>> round(float(front.restitution_measured), 3)
    0.511
    """

    mechanism: Wall | Parapet

    def __post_init__(self) -> None:
        check_type("mechanism", self.mechanism, Wall, Parapet)

    __repr__ = short_repr

    @property
    def instability_displacement(self) -> Array:
        """Displacement u_ins = F0/K0 at which the rigid mechanism has no strength, Eq. (6). [m]"""
        return self.mechanism.instability_displacement

    @property
    def frequency_parameter(self) -> Array:
        """Frequency p = sqrt(K0/m_eff); the dimensionless time is tau = p t. [rad s-1]"""
        return self.mechanism.frequency_parameter

    @property
    def load_factor(self) -> Array:
        """Factor -lambda/(p^2 u_ins) from ground acceleration to dimensionless load. [s2 m-1]"""
        return self.mechanism.load_factor

    @property
    def velocity_scale(self) -> Array:
        """Ground velocity p u_ins/lambda: the velocity ratio is PGV divided by it. [m s-1]"""
        return self.mechanism.velocity_scale

    @property
    def restitution_measured(self) -> Array:
        r"""Restitution of a block that hits a return wall. [-]

        .. math::
            e = 1.05 \, (1 - \tfrac{3}{2} \sin^2 \alpha)^2 \,
            |1 - \tfrac{3}{2} \cos^2 \alpha|, \qquad \tan \alpha = \frac{t}{h}

        It is 0.41 at h/t = 5 and 0.525 for a slender block. Source: Sorrentino, AlShawa and
        Decanini (2011), from a secondary source. It is not known for a wall with a hinge.
        """
        sine2 = 1 / (1 + self.mechanism.slenderness**2)
        return np.asarray(1.05 * (1 - 1.5 * sine2) ** 2 * np.abs(1 - 1.5 * (1 - sine2)))

    def rocking_onset(self, strength_ratio: ArrayLike = 1.0) -> Array:
        """Return the ground acceleration whose static load reaches the plateau. [m s-2]

        Parameters
        ----------
        strength_ratio : float or ndarray
            Strength b1 of the cracked wall divided by F0, 1 for the rigid wall; broadcasts. [-]
        """
        return self.mechanism.rocking_onset(strength_ratio)
