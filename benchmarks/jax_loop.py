"""The same walls by JAX: twelve lines of `lax.scan` over the steps, all histories in one array, peaks alone."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import numpy as np

# One thread, to be set before JAX starts.
os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1")

try:
    import jax
    import jax.numpy as jnp
except ImportError as problem:
    NO_JAX = f"JAX cannot be imported ({problem}); what needs it is left out"
else:
    NO_JAX = ""
    jax.config.update("jax_enable_x64", True)

TINY = 1e-100


def jax_peaks(batch: Any, normalisation: float) -> Callable[[], np.ndarray]:
    """Return a function that runs the histories of a batch and returns their peaks."""
    k1, b1, ks, a1, a2, a3 = (jnp.asarray(row) for row in batch.curve.parameters())
    w1, xi, h = jnp.sqrt(k1), jnp.asarray(batch.parameter), jnp.asarray(batch.step)

    def force(z):
        return jnp.maximum(jnp.minimum(jnp.minimum(k1 * z, b1), ks * (a3 - z)), 0.0)

    def double_energy(z):
        z1, z2, z3 = jnp.minimum(z, a1), jnp.clip(z, a1, a2), jnp.clip(z, a2, a3)
        return k1 * z1 * z1 + 2 * b1 * (z2 - a1) + ks * (z3 - a2) * (2 * a3 - a2 - z3)

    def order_16(z, f, v):
        energy, size = double_energy(z), 2 * xi * normalisation
        root, both = jnp.sqrt(energy), v * v + energy
        size = size * (v * v / both) ** 16
        return size * f / (root * (1 - jnp.minimum(size * v * root / both, 0.95)))

    def band(z, f, v):
        _, (size, reach, _) = batch.damping.kernel_arguments(batch.curve)
        r = jnp.minimum(z / jnp.maximum(reach * jnp.abs(v), 1e-90), 1.0)
        return size * (1 - r * r)

    coefficient = {
        "CR": lambda z, f, v: 0.0,
        "CDC": lambda z, f, v: 2 * w1 * xi,
        "CDR": lambda z, f, v: 2 * xi * jnp.sqrt(f / z),
        "SDR": lambda z, f, v: 2 * xi / w1 * (f / z),
        "ECD": lambda z, f, v: 2 * xi * f / jnp.sqrt(double_energy(z)),
        "ECD order 16": order_16,
        "BAND": band,
    }[batch.model]

    def step(state, loads):
        x, v, a, peak = state
        start, end, rest = factor * loads[0], factor * loads[1], h
        if batch.model == "CR":  # the impact inside the step, where there is one
            after = x + h * (v + 0.5 * h * a)
            hit = ((x > 0) & (after <= 0)) | ((x < 0) & (after >= 0))
            root = jnp.sqrt(jnp.maximum(v * v - 2 * a * x, 0.0)) - jnp.where(x > 0, v, -v)
            s = jnp.where(hit, jnp.minimum(2 * jnp.abs(x) / jnp.maximum(root, TINY), h), 0.0)
            load = start + (end - start) * (s / h)
            v = jnp.where(hit, xi * (v + 0.5 * s * (a + load)), v)
            a, x, rest = jnp.where(hit, load, a), jnp.where(hit, 0.0, x), h - s
        half = v + 0.5 * rest * a
        x = x + rest * half
        z = jnp.maximum(jnp.abs(x), TINY)
        f, ahead = force(z), v + rest * a
        c = coefficient(z, f, jnp.where(x < 0, -ahead, ahead))
        a = (end - jnp.where(x < 0, -f, f) - c * half) / (1 + 0.5 * rest * c)
        return (x, half + 0.5 * rest * a, a, jnp.maximum(peak, jnp.abs(x))), None

    factor, times = jnp.asarray(batch.load_factor), np.arange(batch.steps + 1) / batch.substeps
    ground = np.interp(times, np.arange(len(batch.ground)), batch.ground) if len(batch.ground) else np.zeros(times.size)
    loads = jnp.stack([jnp.asarray(ground[:-1]), jnp.asarray(ground[1:])], axis=1)
    x = jnp.asarray(batch.release, dtype=float)
    start = x, jnp.zeros_like(x), factor * ground[0] - jnp.sign(x) * force(jnp.abs(x)), jnp.abs(x)
    scan = jax.jit(lambda state, loads: jax.lax.scan(step, state, loads)[0][3])
    return lambda: np.asarray(scan(start, loads))
