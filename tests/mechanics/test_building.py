"""Modes of a building as a cantilever of flexure and shear, against equations solved by other means."""

import mpmath
import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

from rockdamp import Building, Diaphragm, InputError, InputWarning
from rockdamp.mechanics.building import RIGID_PERIOD, contributions, eigenvalues, frequency_ratios

ALPHAS = (0.0, 0.3, 2.0, 7.0, 40.0)


def boundary_determinant(gamma, alpha):
    """The boundary conditions at the top, of a solution that meets those at the base, by mpmath."""
    beta = mpmath.sqrt(alpha**2 + gamma**2)
    solutions = (
        lambda x: mpmath.sin(gamma * x) - gamma / beta * mpmath.sinh(beta * x),
        lambda x: mpmath.cos(gamma * x) - mpmath.cosh(beta * x),
    )
    rows = [
        [mpmath.diff(solution, 1, 2) for solution in solutions],
        [mpmath.diff(solution, 1, 3) - alpha**2 * mpmath.diff(solution, 1, 1) for solution in solutions],
    ]
    return mpmath.det(mpmath.matrix(rows))


@pytest.mark.parametrize("alpha", ALPHAS)
def test_the_eigenvalues_meet_the_boundary_conditions_at_the_top(alpha):
    with mpmath.workdps(60):
        for gamma in eigenvalues(alpha, 3):
            exact = mpmath.findroot(lambda g: boundary_determinant(g, mpmath.mpf(alpha)), float(gamma), verify=False)
            assert float(exact) == pytest.approx(float(gamma), rel=1e-12)


def finite_elements(alpha, count):
    """Frequencies and contributions at the nodes of beams with cubic displacements, for EI = m' = H = 1."""
    elements = 60
    size = 1 / elements
    flexure = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]]) / size**3
    shear = np.array([[36, 3, -36, 3], [3, 4, -3, -1], [-36, -3, 36, -3], [3, -1, -3, 4]]) / (30 * size)
    mass = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]) * size / 420
    scale = np.outer(*2 * [[1, size, 1, size]])
    stiffness, inertia = np.zeros((2, 2 * elements + 2, 2 * elements + 2))
    for element in range(elements):
        part = np.s_[2 * element : 2 * element + 4, 2 * element : 2 * element + 4]
        stiffness[part] += scale * (flexure + alpha**2 * shear)
        inertia[part] += scale * mass
    square, vectors = eigh(stiffness[2:, 2:], inertia[2:, 2:])
    moved = np.tile([1.0, 0.0], elements)  # as a rigid body with the ground
    contribution = vectors * (vectors.T @ inertia[2:, 2:] @ moved + vectors.T @ inertia[2:, :2] @ [1.0, 0.0])
    return np.sqrt(square[:count]), contribution[::2, :count]


@pytest.mark.parametrize("alpha", ALPHAS)
def test_frequencies_and_contributions_are_those_of_finite_elements(alpha):
    frequency, contribution = finite_elements(alpha, 4)
    assert frequency_ratios(alpha, 4) == pytest.approx(frequency / frequency[0], rel=1e-4)
    height = np.arange(1, 61) / 60
    assert contributions(alpha, 4, height) == pytest.approx(contribution, abs=1e-3)


@pytest.mark.parametrize("alpha", [*ALPHAS, np.inf])
def test_modes_are_orthogonal_and_their_effective_masses_sum_to_the_whole(alpha):
    nodes, weights = np.polynomial.legendre.leggauss(400)
    height, weight = (nodes + 1) / 2, weights / 2
    shapes = contributions(alpha, 40, height)
    products = shapes.T @ (weight[:, None] * shapes)
    # Gamma phi times itself integrates to the effective mass, which is also the integral of Gamma phi.
    assert products == pytest.approx(np.diag(weight @ shapes), abs=1e-9)
    assert weight @ shapes.sum(axis=1) == pytest.approx(1, abs=0.011)
    # A floor has all of the ground's motion in its modes, to which the series tends in the mean.
    assert weight @ np.abs(shapes.sum(axis=1) - 1) < 0.05


def published(alpha, count, height):
    """Period ratios and contributions by Taghavi and Miranda (2005), Eqs. (10), (22), (24) and (25).

    As github.com/GNS-Science/srwg-risk-toolbox quotes them (srwg_risk_toolbox/modal_approximation.py), with its
    correction of Eq. (22): the integrals by quadrature, the roots by a fine grid.
    """

    def equation(gamma):
        beta = np.hypot(gamma, alpha)
        both = (2 + alpha**4 / (gamma * beta) ** 2) * np.cos(gamma) * np.cosh(beta)
        return 2 + both + alpha**2 / (gamma * beta) * np.sin(gamma) * np.sinh(beta)

    grid = np.linspace(1e-2, count * np.pi, 2000)
    ends = np.flatnonzero(np.diff(np.sign(equation(grid))))
    gamma = np.array([brentq(equation, *grid[[end, end + 1]], xtol=1e-13) for end in ends])
    beta = np.hypot(gamma, alpha)
    nu = (gamma**2 * np.sin(gamma) + gamma * beta * np.sinh(beta)) / (
        gamma**2 * np.cos(gamma) + beta**2 * np.cosh(beta)
    )

    def shape(x):
        bent = np.sin(gamma * x) - gamma / beta * np.sinh(x * beta)
        return bent + nu * (np.cosh(x * beta) - np.cos(gamma * x))

    nodes, weights = np.polynomial.legendre.leggauss(60)
    shapes = shape((nodes[:, None] + 1) / 2)
    participation = (weights @ shapes) / (weights @ shapes**2)
    ratio = gamma[0] / gamma * np.sqrt((gamma[0] ** 2 + alpha**2) / (gamma**2 + alpha**2))
    return ratio, participation * shape(np.asarray(height)[:, None])


@pytest.mark.parametrize("alpha", [0.01, 0.3, 2.0, 7.0])
def test_period_ratios_and_contributions_are_those_of_the_published_equations(alpha):
    height = np.arange(1, 11) / 10
    ratio, contribution = published(alpha, 4, height)
    assert 1 / frequency_ratios(alpha, 4) == pytest.approx(ratio, rel=1e-10)
    assert contributions(alpha, 4, height) == pytest.approx(contribution, abs=1e-8)


def test_flexure_and_shear_are_the_limits():
    assert contributions(0.0, 3, 1.0) == pytest.approx(contributions(1e-4, 3, 1.0), abs=1e-6)
    assert contributions(np.inf, 3, [0.3, 1.0]) == pytest.approx(contributions(1e5, 3, [0.3, 1.0]), abs=1e-4)
    assert frequency_ratios(np.inf, 3).tolist() == [1, 3, 5]
    assert contributions(np.inf, 3, 1.0)[0] == pytest.approx(4 / np.pi / np.array([1, -3, 5]))
    # A cantilever in flexure: cos cosh = -1, and the integral of phi^2 is a quarter of that at the top.
    gamma = eigenvalues(0.0, 4)
    assert np.cos(gamma) * np.cosh(gamma) == pytest.approx(-np.ones(4), abs=1e-9)
    assert frequency_ratios(0.0, 3) == pytest.approx([1, 6.2669, 17.547], rel=1e-4)
    sigma = (np.sinh(gamma) - np.sin(gamma)) / (np.cosh(gamma) + np.cos(gamma))
    assert contributions(0.0, 4, 1.0)[0] == pytest.approx(4 * sigma / gamma * [1, -1, 1, -1], rel=1e-9)


def test_modes_that_are_as_stiff_as_the_ground_are_left_out():
    modes = Building(period=0.25, storeys=6, storey=6).modes
    assert modes.period.size == 4 and modes.period[-1] >= RIGID_PERIOD
    with pytest.warns(InputWarning):
        rigid = Building(period=0.5 * RIGID_PERIOD, storeys=2, storey=1)
    assert rigid.modes.period.size == 0 and rigid.modes.contribution.shape == (2, 0)
    assert Building(period=0.25, storeys=3, storey=1).modes.contribution[0] == pytest.approx(np.zeros(3), abs=1e-15)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"storey": 4}, "storey is 4; it must be at most 3, the storeys of the building"),
        ({"storey": 0}, "storey is 0; it must be a whole number, at least 1"),
        ({"damping_ratio": 5.0}, "was it in per cent \\(0.05\\)"),
        ({"period": 0.0}, "period of the building is 0.0; it must be greater than 0"),
        ({"shape": "frame"}, "must be uniform, flexural, or a shear ratio alpha"),
        ({"shape": -1.0}, "at least 0 as a shear ratio"),
    ],
)
def test_buildings_that_cannot_be_are_refused(change, words):
    with pytest.raises(InputError, match=words):
        Building(**({"period": 0.25, "storeys": 3, "storey": 3} | change))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"period": 3.0}, "was it a frequency in Hz \\(0.333 s\\)"),
        ({"period": 250.0}, "was it in milliseconds \\(0.25 s\\)"),
        ({"damping_ratio": 0.5}, "usual is 0.005 to 0.2; was it in per cent"),
        ({"damping_ratio": 0.0005}, "usual is 0.005 to 0.2; was it 0.05"),
    ],
)
def test_unlikely_buildings_are_questioned(change, words):
    with pytest.warns(InputWarning, match=words):
        Building(**({"period": 0.25, "storeys": 3, "storey": 3} | change))


def test_unlikely_floors_are_questioned_as_buildings_are():
    with pytest.warns(InputWarning, match=r"diaphragm period is 400 s; .*was it in milliseconds \(0.4 s\)"):
        Diaphragm(400)
    with pytest.warns(InputWarning, match="diaphragm damping is 0.4; .*were period and damping swapped"):
        Diaphragm(0.05, 0.4)
