"""The march of peaks by JAX: `lax.scan` over the steps, all walls in one array, one thread."""

from __future__ import annotations

import os
from collections.abc import Callable

import numpy as np
from walls import STEP, STEPS, SUBSTEPS, Walls

os.environ.setdefault(
    "XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
)  # before JAX

import jax
import jax.numpy as jnp

jax.config.update("jax_enable_x64", True)
TINY = 1e-100


def jax_peaks(walls: Walls) -> Callable[[], np.ndarray]:
    """Return a function that runs the walls by JAX and returns their peaks."""
    model = walls.damping.model
    h = STEP
    k1, b1, ks, a1, a2, a3 = (jnp.asarray(row) for row in walls.curve.parameters())
    w1 = jnp.sqrt(k1)
    xi = jnp.asarray(walls.damping.value)
    factor = jnp.asarray(walls.factor)

    def force(z):
        return jnp.maximum(jnp.minimum(jnp.minimum(k1 * z, b1), ks * (a3 - z)), 0.0)

    def double_energy(z):
        z1 = jnp.minimum(z, a1)
        z2 = jnp.clip(z, a1, a2)
        z3 = jnp.clip(z, a2, a3)
        return k1 * z1 * z1 + 2 * b1 * (z2 - a1) + ks * (z3 - a2) * (2 * a3 - a2 - z3)

    def band(z, f, v):
        size, reach, _ = walls.damping.kernel_arguments(walls.curve)[1]
        r = jnp.minimum(z / jnp.maximum(reach * jnp.abs(v), 1e-90), 1.0)
        return size * (1 - r * r)

    coefficient = {
        "CR": lambda z, f, v: 0.0,
        "CDC": lambda z, f, v: 2 * w1 * xi,
        "CDR": lambda z, f, v: 2 * xi * jnp.sqrt(f / z),
        "SDR": lambda z, f, v: 2 * xi / w1 * (f / z),
        "ECD": lambda z, f, v: 2 * xi * f / jnp.sqrt(double_energy(z)),
        "BAND": band,
    }[model]

    def step(state, loads):
        x, v, a, peak = state
        start = factor * loads[0]
        end = factor * loads[1]
        rest = h
        if model == "CR":  # the impact inside the step, where there is one
            x_end = x + h * (v + 0.5 * h * a)
            hit = ((x > 0) & (x_end <= 0)) | ((x < 0) & (x_end >= 0))
            root = jnp.sqrt(jnp.maximum(v * v - 2 * a * x, 0.0)) - jnp.where(x > 0, v, -v)
            s = jnp.where(hit, jnp.minimum(2 * jnp.abs(x) / jnp.maximum(root, TINY), h), 0.0)
            load = start + (end - start) * (s / h)
            v = jnp.where(hit, xi * (v + 0.5 * s * (a + load)), v)
            a = jnp.where(hit, load, a)
            x = jnp.where(hit, 0.0, x)
            rest = h - s
        half = v + 0.5 * rest * a
        x = x + rest * half
        z = jnp.maximum(jnp.abs(x), TINY)
        f = force(z)
        c = coefficient(z, f, v + rest * a)
        a = (end - jnp.where(x < 0, -f, f) - c * half) / (1 + 0.5 * rest * c)
        return (x, half + 0.5 * rest * a, a, jnp.maximum(peak, jnp.abs(x))), None

    samples = np.arange(STEPS + 1) / SUBSTEPS
    ground = np.interp(samples, np.arange(walls.ground.size), walls.ground)
    loads = jnp.stack([jnp.asarray(ground[:-1]), jnp.asarray(ground[1:])], axis=1)
    zeros = jnp.zeros(walls.factor.size)
    start = (zeros, zeros, factor * ground[0], zeros)

    @jax.jit
    def scan(state, loads):
        (_, _, _, peak), _ = jax.lax.scan(step, state, loads)
        return peak

    return lambda: np.asarray(scan(start, loads))
