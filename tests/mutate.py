"""Break one equation at a time and see that the suite notices: `.venv/bin/python tests/mutate.py [NAME ...]`.

Run by hand. Each mutation is made in a copy of the package, against which the tests named with it run until one fails.
The last line counts; the exit status is 1 if any mutation survives, or no longer finds the text that it changes.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]


class Mutation(NamedTuple):
    """One wrong equation, and the tests that should notice first."""

    name: str
    file: str
    right: str
    wrong: str
    tests: str


MUTATIONS = [
    Mutation("F0 without the factor 2 of W + O", "wall.py",
             "2 * (self.weight + self.overburden) * t / self.lower_height",
             "(self.weight + self.overburden) * t / self.lower_height", "test_wall.py test_derivations.py"),
    Mutation("h1 for h2 in F0", "wall.py", "self.overburden * (t + 2 * ecc) / self.upper_height",
             "self.overburden * (t + 2 * ecc) / self.lower_height", "test_wall.py test_derivations.py"),
    Mutation("sign of the eccentricity", "wall.py", "self.overburden * (t + 2 * ecc) / self.upper_height",
             "self.overburden * (t - 2 * ecc) / self.upper_height", "test_wall.py test_derivations.py"),
    Mutation("K0 with O in place of 2 O", "wall.py", "+ 2 * self.overburden / self.upper_height",
             "+ self.overburden / self.upper_height", "test_wall.py test_derivations.py"),
    Mutation("m_eff = m", "wall.py", "return 2 * self.mass / 3", "return self.mass", "test_wall.py"),
    Mutation("lambda = 2/3", "wall.py", "EXCITATION_FACTOR = 1.5", "EXCITATION_FACTOR = 2 / 3", "test_wall.py"),
    Mutation("Eq. (7) with t^2 in place of 3 t^2", "wall.py", "(product - 3 * np.square(self.thickness))",
             "(product - np.square(self.thickness))", "test_wall.py test_derivations.py"),
    Mutation("impulsive restitution with 6 - 4 r", "wall.py", "(6 - 5 * r) * q", "(6 - 4 * r) * q",
             "test_wall.py test_derivations.py"),
    Mutation("Housner with sin alpha in place of its square", "wall.py", "1 - 1.5 / (1 + self.slenderness**2)",
             "1 - 1.5 / (1 + self.slenderness**2) ** 0.5", "test_wall.py test_derivations.py"),
    Mutation("translated plateau ends at 1 - b1", "curve.py",
             'start = 1.0 if self.softening == "steeper" else self.ultimate_ratio', "start = 1.0", "test_curve.py"),
    Mutation("a2 for a1 in the stored energy", "kernels.py", "z2 = np.minimum(np.maximum(z, a1), a2)",
             "z2 = np.minimum(np.maximum(z, a2), a2)", "test_curve.py test_energy.py"),
    Mutation("plateau energy without the factor 2", "kernels.py", "+ 2.0 * b1 * (z2 - a1)", "+ b1 * (z2 - a1)",
             "test_curve.py test_energy.py"),
    Mutation("sign of the softening tangent", "kernels.py", "return k1 * (z < a1) - ks", "return k1 * (z < a1) + ks",
             "test_curve.py"),
    Mutation("e^2 for e at a located impact", "kernels.py", "v = w[E + i] * (v + 0.5 * s * (a + load)) if hit else v",
             "v = w[E + i] ** 2 * (v + 0.5 * s * (a + load)) if hit else v", "test_newmark.py test_exact.py"),
    Mutation("impact at the end of the step in the located scheme", "kernels.py",
             "s = impact_within(x, v, a, h) if hit else 0.0", "s = h if hit else 0.0",
             "test_kernels_without_jit.py test_convergence.py test_newmark.py"),
    Mutation("e^2 for e at a printed impact", "kernels.py", "v = w[E + i] * v if crossed",
             "v = w[E + i] ** 2 * v if crossed", "test_kernels_without_jit.py test_newmark.py"),
    Mutation("half of the load's step forgotten", "kernels.py", "(1.0 + 0.5 * h * c)", "(1.0 + h * c)",
             "test_newmark.py test_kernels_without_jit.py test_convergence.py"),
    Mutation("collapse at a2", "kernels.py", "alive & (z <= w[A3 + i])", "alive & (z <= w[A2 + i])",
             "test_newmark.py"),
    Mutation("Eq. (17) with the squares' difference", "kernels.py", "w[ERROR + i] += difference * difference",
             "w[ERROR + i] += difference", "test_newmark_batches.py test_matching.py test_newmark.py"),
    Mutation("Eq. (17) with signed displacements", "kernels.py",
             "np.abs(reference[row[i], step]) - np.abs(w[X + i])", "reference[row[i], step] - w[X + i]",
             "test_newmark_batches.py test_matching.py test_newmark.py"),
    Mutation("CDC with n = 1", "damping.py", "return {kernels.C0: 2 * w1 * xi}", "return {kernels.C1: 2 * w1 * xi}",
             "test_damping.py"),
    Mutation("CDR without the factor 2", "damping.py", "return {kernels.C1: 2 * xi}\n",
             "return {kernels.C1: xi}\n", "test_damping.py"),
    Mutation("SDR over w1^2", "damping.py", "2 * xi / w1}", "2 * xi / w1**2}", "test_damping.py"),
    Mutation("n off by one in the general exponent", "damping.py", "2 * xi * w1 ** (1 - n)", "2 * xi * w1 ** (2 - n)",
             "test_damping.py"),
    Mutation("ECD without the root", "kernels.py", "c_root * np.sqrt(w2) + c_linear * w2",
             "c_root * w2 + c_linear * w2", "test_damping.py test_energy.py"),
    Mutation("delta = 1 - e", "energy.py", "    delta = 0.0 - np.log(e)\n", "    delta = 1 - e\n",
             "test_energy.py test_single.py"),
    Mutation("pi for pi^2 in the exact ratio", "energy.py", "np.hypot(np.pi, delta)", "np.hypot(np.sqrt(np.pi), delta)",
             "test_energy.py test_exact.py test_newmark.py"),
    Mutation("Giannini and Masiani with 1 - e below", "energy.py", "(np.pi * (1 + e))", "(np.pi * (2 - e))",
             "test_energy.py"),
    Mutation("work of the damper without its square root", "energy.py",
             "2 * s * unit.coefficient(curve, x) * speed", "2 * s * unit.coefficient(curve, x) * speed**2",
             "test_energy.py"),
    Mutation("covariance over e.size in place of its degrees of freedom", "equivalence.py",
             "max(e.size - DEGREE - 1, 1)", "e.size", "test_stages.py"),
    Mutation("the larger of two equal minima", "matching.py", "if value < best.error[w, c]:",
             "if value <= best.error[w, c]:", "test_matching.py"),
    Mutation("e^2 for e in the event-driven reference", "exact.py", "self.v *= self.restitution  # Eq. (8)",
             "self.v *= self.restitution**2", "test_exact.py"),
]  # fmt: skip


def run(mutation: Mutation, folder: Path) -> str:
    """Return the first failing test, or an empty string where the mutation survives."""
    source = folder / "src"
    shutil.rmtree(source, ignore_errors=True)
    shutil.copytree(ROOT / "src", source, ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))
    path = source / "rockdamp" / mutation.file
    text = path.read_text(encoding="utf-8")
    if text.count(mutation.right) < 1:
        raise SystemExit(f"{mutation.name}: {mutation.file} does not hold {mutation.right!r} any more")
    path.write_text(text.replace(mutation.right, mutation.wrong), encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": str(source), "NUMBA_CACHE_DIR": str(folder / "cache")}
    tests = [str(ROOT / "tests" / name) for name in mutation.tests.split()]
    command = [sys.executable, "-m", "pytest", "-x", "-q", "--no-header", "-p", "no:cacheprovider", "--tb=no", *tests]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    shutil.rmtree(folder / "cache", ignore_errors=True)
    if done.returncode == 0:
        return ""
    failed = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return failed[0].split(" - ")[0].split("::", 1)[-1] if failed else f"exit status {done.returncode}"


def main() -> int:
    """Run the mutations whose names contain one of the arguments, or all."""
    chosen = [m for m in MUTATIONS if not sys.argv[1:] or any(word in m.name for word in sys.argv[1:])]
    survivors = 0
    print("| mutation | file | noticed by | s |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for mutation in chosen:
            start = time.perf_counter()
            noticed = run(mutation, Path(folder))
            survivors += not noticed
            seconds = time.perf_counter() - start
            print(f"| {mutation.name} | {mutation.file} | {noticed or '**survived**'} | {seconds:.0f} |", flush=True)
    print(f"{len(chosen) - survivors} of {len(chosen)} noticed")
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
