"use strict";
// Free decays in the reader's browser, by the steps of rockdamp/solvers/step_kernel.py: explicit Newmark, impacts located inside the step. Tests hold
// both against each other.

function freeDecays(form) {
  const crossed = (before, after) => (before > 0 && after <= 0) || (before < 0 && after >= 0);

  // Time from the start of a step of length h to the root of x + v s + a s^2/2, known to lie in it.
  function impactWithin(x, v, a, h) {
    const away = x > 0 ? v : -v;
    const root = Math.sqrt(Math.max(v * v - 2 * a * x, 0));
    return Math.min((2 * Math.abs(x)) / Math.max(root - away, 1e-100), h);
  }

  // Displacements at every step, from rest at x0. `coefficient` of |x| and the velocity away from 0, or none for impacts with e.
  function decay(curve, x0, { e, coefficient }, step, steps) {
    const history = new Float64Array(steps + 1);
    let [x, v] = [x0, 0];
    let a = -form.force(curve, x0);
    history[0] = x;
    for (let k = 1; k <= steps; k += 1) {
      let [h, c] = [step, 0];
      let next = x + h * (v + 0.5 * h * a);
      if (coefficient) {
        c = coefficient(Math.abs(next), next < 0 ? -v - h * a : v + h * a);
      } else if (crossed(x, next)) {
        const s = impactWithin(x, v, a, h);
        v = e * (v + 0.5 * s * a); // no force acts at x = 0
        a = 0;
        h -= s;
        next = h * v;
      }
      x = next;
      const f = form.force(curve, Math.abs(x));
      const half = v + 0.5 * h * a;
      a = ((x < 0 ? f : -f) - c * half) / (1 + 0.5 * h * c);
      v = half + 0.5 * h * a;
      history[k] = x;
    }
    return history;
  }

  // Of one setting: under restitution, and under each damper at the ratio of its closed form.
  function decays(setting, models, step, steps) {
    const curve = form.curve(setting);
    return Object.fromEntries(models.map((model) => {
      const xi = form.dampingRatio(curve, model, setting.e, setting.x0);
      const coefficient = (z, speed) => form.coefficient(curve, model, z, speed, xi);
      return [model, { xi, x: decay(curve, setting.x0, { coefficient }, step, steps) }];
    }));
  }

  // Root mean square of what Eq. (17) sums, over the steps up to `count`.
  function rmsError(reference, x, count) {
    let sum = 0;
    for (let k = 1; k <= count; k += 1) sum += (Math.abs(reference[k]) - Math.abs(x[k])) ** 2;
    return Math.sqrt(sum / count);
  }

  return { decay, decays, rmsError };
}

if (typeof module !== "undefined") module.exports = freeDecays;
