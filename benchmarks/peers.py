"""The same walls by other means: a C loop, OpenSeesPy, SciPy, and a plain numba loop over one history at a time.

Everything is dimensionless, as in rockdamp.solvers.kernel.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

from rockdamp import Damping, TrilinearCurve
from rockdamp.mechanics.damping import normalisation
from rockdamp.solvers.kernel import LANES

SOURCE = Path(__file__).with_name("scheme.c")
FLAGS = ("-O3", "-march=native", "-ffast-math")

# --- C ----------------------------------------------------------------------------------------------------------------

C_ROWS = (
    "x",
    "v",
    "a",
    "alive",
    "end",
    "peak",
    "peak_at",
    "crossings",
    "k1",
    "b1",
    "ks",
    "a1",
    "a2",
    "a3",
    "h",
    "g",
    "e",
    "c",
)


def compile_c(source: Path = SOURCE, *flags: str) -> ctypes.CDLL | None:
    """Compile the C loop into a temporary folder; None where there is no compiler."""
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        return None
    folder = tempfile.mkdtemp()
    library = f"{folder}/scheme.so"
    try:
        subprocess.run([compiler, *FLAGS, *flags, "-shared", "-fPIC", str(source), "-o", library, "-lm"], check=True)
        return ctypes.CDLL(library)
    finally:
        shutil.rmtree(folder)  # what is loaded stays


def c_version() -> str:
    """Name and version of the compiler."""
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        return "no C compiler"
    return subprocess.run([compiler, "--version"], capture_output=True, text=True).stdout.splitlines()[0]


class CLoop:
    """The C loop on one batch; `run` starts from the same state each time, as `rockdamp.solve` does."""

    def __init__(self, library: ctypes.CDLL, batch: Any) -> None:
        self.march = getattr(library, f"march_{batch.model.replace(' ', '_')}")
        self.march.argtypes = [ctypes.c_void_p, ctypes.c_long, ctypes.c_void_p] + [ctypes.c_long] * 3
        self.batch, self.blocks = batch, -(-batch.lanes // LANES)
        self.ground = np.ascontiguousarray(batch.ground, dtype=float)
        self.start = self._pack()
        self.work = self.start.copy()

    def _pack(self) -> np.ndarray:
        batch, curve = self.batch, self.batch.curve
        k1, b1, ks, a1, a2, a3 = curve.parameters()
        w1, xi, x = curve.initial_frequency, batch.parameter, batch.release
        size, reach = batch.damping.kernel_arguments(curve)[1][:2] if batch.model == "BAND" else (0.0, 1.0)
        c = {
            "CR": 0.0,
            "CDC": 2 * w1 * xi,
            "CDR": 2 * xi,
            "SDR": 2 * xi / w1,
            "ECD": 2 * xi,
            ORDER_16: 2 * NORMALISATION * xi,
            "BAND": size,
        }[batch.model]
        load = batch.load_factor * self.ground[0] if self.ground.size else 0.0
        rows = {
            "x": x,
            "a": load - curve.force(x),
            "alive": 1.0,
            "peak": np.abs(x),
            "k1": k1,
            "b1": b1,
            "ks": ks,
            "a1": a1,
            "a2": a2,
            "a3": a3,
            "h": batch.step,
            "g": batch.load_factor,
            "e": xi if batch.model == "CR" else reach,
            "c": c,
        }
        flat = np.zeros((len(C_ROWS), self.blocks * LANES))
        for row, name in enumerate(C_ROWS):
            flat[row, : batch.lanes] = rows.get(name, 0.0)
            flat[row, batch.lanes :] = flat[row, batch.lanes - 1]
        return np.ascontiguousarray(flat.reshape(len(C_ROWS), self.blocks, LANES).swapaxes(0, 1))

    def run(self, threads: int = 1) -> None:
        """Run every block; threads take equal shares."""
        np.copyto(self.work, self.start)
        edges = np.linspace(0, self.blocks, threads + 1).astype(int)
        if threads == 1:
            self._part(0, self.blocks)
            return
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(self._part, edges[:-1], edges[1:]))

    def _part(self, first: int, last: int) -> None:
        batch = self.batch
        self.march(
            self.work[first:last].ctypes.data,
            int(last - first),
            self.ground.ctypes.data,
            self.ground.size,
            batch.substeps,
            batch.steps,
        )

    def row(self, name: str) -> np.ndarray:
        """Return what a row holds after the run."""
        return self.work[:, C_ROWS.index(name)].reshape(-1)[: self.batch.lanes]


ORDER_16 = "ECD order 16"
SCALAR_MODELS = ("CR", "CDC", "CDR", "SDR", "ECD", ORDER_16, "BAND")
NORMALISATION = float(normalisation(16))  # N_m


# --- numba, one history at a time -------------------------------------------------------------------------------------


@njit(fastmath=True, error_model="numpy")
def _march_one(model, k1, b1, ks, a1, a2, a3, w1, parameter, x, g, h, ground, substeps, steps):
    """Peak, its step, crossings and last step of one history; models 0 to 6: those of `SCALAR_MODELS`."""
    v, crossings, peak, peak_at, end = 0.0, 0, abs(x), 0, steps
    f = max(min(k1 * abs(x), b1, ks * (a3 - abs(x))), 0.0)
    p1 = ground[0] * g if ground.size else 0.0
    a = p1 - (f if x > 0 else -f)
    for step in range(1, steps + 1):
        p0 = p1
        if ground.size:
            sample, part = divmod(step, substeps)
            p1 = ground[sample]
            if part:
                p1 += (ground[sample + 1] - p1) * part / substeps
            p1 *= g
        old, rest = x, h
        half = v + 0.5 * h * a
        x += h * half
        crosses = (old > 0 and x <= 0) or (old < 0 and x >= 0)
        if crosses:
            crossings += 1
        if model == 0 and crosses:  # located impact
            away = v if old > 0 else -v
            root = np.sqrt(max(v * v - 2 * a * old, 0.0))
            s = min(2 * abs(old) / max(root - away, 1e-100), h)
            load = p0 + (p1 - p0) * (s / h)
            v = parameter * (v + 0.5 * s * (a + load))
            a, rest = load, h - s
            half = v + 0.5 * rest * a
            x = rest * half
        z = abs(x)
        f = max(min(k1 * z, b1, ks * (a3 - z)), 0.0)
        c, z = 0.0, max(z, 1e-100)
        if model == 1:
            c = 2 * w1 * parameter
        elif model == 2:
            c = 2 * parameter * np.sqrt(f / z)
        elif model == 3:
            c = 2 * parameter / w1 * (f / z)
        elif model == 6:
            r = min(z / max(0.2 / w1 * abs(v + h * a), 1e-90), 1.0)
            c = parameter * (1 - r * r)
        elif model >= 4:
            z1, z2, z3 = min(z, a1), min(max(z, a1), a2), min(max(z, a2), a3)
            double_v = k1 * z1 * z1 + 2 * b1 * (z2 - a1) + ks * (z3 - a2) * (2 * a3 - a2 - z3)
            c = 2 * parameter * f / np.sqrt(double_v)
            if model == 5:
                speed = v + h * a if x > 0 else -v - h * a
                total = speed**2 + double_v
                q = 2 * parameter * NORMALISATION * (speed**2 / total) ** 16
                c = f * q / (np.sqrt(double_v) * (1 - q * speed * np.sqrt(double_v) / total))
        a = (p1 - (f if x > 0 else -f) - c * half) / (1 + 0.5 * rest * c)
        v = half + 0.5 * rest * a
        if z > peak:
            peak, peak_at = z, step
        if z > a3:
            end = step
            break
    return peak, peak_at, crossings, end


@njit(fastmath=True, error_model="numpy")
def _march_many(model, k1, b1, ks, a1, a2, a3, w1, parameter, x, g, h, ground, substeps, steps, peak):
    for i in range(peak.size):
        peak[i] = _march_one(
            model,
            k1[i],
            b1[i],
            ks[i],
            a1[i],
            a2[i],
            a3[i],
            w1[i],
            parameter[i],
            x[i],
            g[i],
            h,
            ground,
            substeps,
            steps,
        )[0]


def scalar_peaks(batch: Any, lanes: int) -> np.ndarray:
    """Peaks of the first `lanes` histories of a batch by the plain loop."""
    peak = np.empty(lanes)
    model = SCALAR_MODELS.index(batch.model)
    curve = batch.curve
    parameters = [np.broadcast_to(row, batch.lanes) for row in curve.parameters()]
    parameter = batch.damping.kernel_arguments(curve)[1][0] if batch.model == "BAND" else batch.parameter
    _march_many(
        model,
        *parameters,
        curve.initial_frequency,
        parameter,
        batch.release,
        batch.load_factor,
        batch.step,
        np.asarray(batch.ground, dtype=float),
        batch.substeps,
        batch.steps,
        peak,
    )
    return peak


# --- OpenSees ---------------------------------------------------------------------------------------------------------

try:
    import openseespy.opensees as ops
except (ImportError, RuntimeError, OSError) as problem:  # absent, or without its system libraries
    ops = None
    NO_OPENSEES = f"OpenSeesPy cannot be imported ({problem}); what needs it is left out"
else:
    NO_OPENSEES = ""


def opensees(curve: TrilinearCurve, xi: float, release: float, load: Any = (), sample: float = 0.0) -> None:
    """Set up one CDC wall of unit mass: averaged acceleration with Newton's iterations."""
    strain = np.array(
        [0.0, curve.yield_displacement_ratio, curve.plateau_end, curve.ultimate_displacement_ratio, 100.0]
    )
    b1 = float(curve.strength_ratio)
    stress = np.array([0.0, b1, b1, 0.0, 0.0])
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.node(2, 0.0)
    ops.fix(1, 1)
    ops.mass(2, 1.0)
    law = ("-strain", *(-strain[:0:-1]), *strain, "-stress", *(-stress[:0:-1]), *stress)
    ops.uniaxialMaterial("ElasticMultiLinear", 1, 0.0, *map(_plain, law))
    ops.uniaxialMaterial("Viscous", 2, float(2 * curve.initial_frequency * xi), 1.0)
    ops.uniaxialMaterial("Parallel", 3, 1, 2)
    ops.element("zeroLength", 1, 1, 2, "-mat", 3, "-dir", 1)
    acceleration = -float(curve.force(release))
    if len(load):
        ops.timeSeries("Path", 1, "-dt", sample, "-values", *np.asarray(load).tolist(), "-factor", -1.0)
        ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
        acceleration += float(load[0])
    ops.setNodeDisp(2, 1, float(release), "-commit")
    ops.setNodeAccel(2, 1, acceleration, "-commit")
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", 1e-10, 50)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")


def _plain(value: Any) -> Any:
    return value if isinstance(value, str) else float(value)


def opensees_run(steps: int, step: float) -> None:
    """Advance the wall that is set up."""
    assert ops.analyze(steps, step) == 0


def opensees_history(samples: int, substeps: int, sample: float) -> np.ndarray:
    """Displacements at the samples, the start among them, of the wall that is set up."""
    found = [ops.nodeDisp(2, 1)]
    for _ in range(samples):
        opensees_run(substeps, sample / substeps)
        found.append(ops.nodeDisp(2, 1))
    return np.array(found)


# --- SciPy ------------------------------------------------------------------------------------------------------------


def scipy_history(
    curve: TrilinearCurve,
    xi: float,
    release: float,
    end: float,
    rtol: float,
    load: Any = (),
    sample: float = 1.0,
    times: Any = None,
) -> Any:
    """One CDC wall by DOP853 on plain Python numbers, as fast as `solve_ivp` gets."""
    rates = _rates(curve, xi, np.asarray(load, dtype=float).tolist(), sample)
    return solve_ivp(rates, (0.0, end), (release, 0.0), method="DOP853", rtol=rtol, atol=0.1 * rtol, t_eval=times)


def _rates(curve: TrilinearCurve, xi: float, load: list[float], sample: float) -> Callable[[float, Any], Any]:
    k1, b1, ks, _, _, a3 = (float(value) for value in curve.parameters())
    c, last = float(Damping("CDC", xi).coefficient(curve, 0.0)), len(load) - 2

    def rates(t: float, state: Any) -> tuple[float, float]:
        x, v = state.tolist()
        z = abs(x)
        f = max(min(k1 * z, b1, ks * (a3 - z)), 0.0)
        p = 0.0
        if load:
            at = t / sample
            i = min(int(at), last)
            p = load[i] + (load[i + 1] - load[i]) * (at - i)
        return v, p - (f if x > 0 else -f) - c * v

    return rates
