"use strict";
// The damping ratio of least Err, Eq. (17), searched in the reader's browser as rockdamp/equivalence/matching.py searches it: the basin by a scan,
// then the least integral at the solver's step and at the finest. Tests hold both against each other.

function leastError(form, solver, { scan, every, rivals, nodes, inner, half_width: halfWidth, widest, moves, refinement }) {
  // Of one setting over so many steps: a function of the damping ratio that gives Err and the trapezoidal integral, in which the last
  // sample counts half, over the step.
  function against(curve, { e, x0 }, model, step, steps) {
    const reference = solver.decay(curve, x0, { e }, step, steps);
    return (xi) => {
      const coefficient = (z, speed) => form.coefficient(curve, model, z, speed, xi);
      const history = solver.decay(curve, x0, { coefficient }, step, steps);
      let [sum, last] = [0, 0];
      for (let k = 1; k <= steps; k += 1) {
        last = (Math.abs(reference[k]) - Math.abs(history[k])) ** 2;
        sum += last;
      }
      return { err: sum, integral: sum - last / 2 };
    };
  }

  // The coefficients of the least-squares cubic but the constant one, by the normal equations.
  function cubic(at, values) {
    const rows = Array.from({ length: 4 }, (_, i) => [
      ...Array.from({ length: 4 }, (_, j) => at.reduce((sum, s) => sum + s ** (i + j), 0)),
      at.reduce((sum, s, k) => sum + s ** i * values[k], 0),
    ]);
    for (let i = 0; i < 4; i += 1) {
      for (let j = 0; j < 4; j += 1) {
        if (j === i) continue;
        const part = rows[j][i] / rows[i][i];
        for (let k = i; k < 5; k += 1) rows[j][k] -= part * rows[i][k];
      }
    }
    return rows.map((row, i) => row[4] / row[i]).slice(1);
  }

  // The place in [-1, 1] where the cubic is least: its minimum, or the end downhill.
  function leastOf([slope, curvature, third]) {
    const root = Math.sqrt(Math.max(curvature ** 2 - 3 * slope * third, 0));
    const place = curvature + root > 0 ? -slope / (curvature + root) : -Math.sign(slope);
    return Math.max(-1, Math.min(1, place));
  }

  // The damping ratio of the least integral next to the one given; not a number where no range holds it.
  function integralMinimum(errors, step, start) {
    const width = Math.min(halfWidth * step, widest);
    let middle = start;
    for (let move = 0; move < moves; move += 1) {
      const place = leastOf(cubic(nodes, nodes.map((node) => errors(middle * (1 + width * node)).integral)));
      middle *= 1 + width * place;
      if (Math.abs(place) <= inner) return middle;
    }
    return NaN;
  }

  // xi and an empty text, or no xi and why.
  function search(setting, model, step, steps) {
    if (setting.e === 1) return { xi: 0, refusal: "" };
    const curve = form.curve(setting);
    const coarse = against(curve, setting, model, step * every, Math.max(1, Math.floor(steps / every)));
    const guess = form.dampingRatio(curve, model, setting.e, setting.x0);
    const trial = scan.map((factor) => guess * factor);
    const err = trial.map((xi) => coarse(xi).err);
    const lowest = Math.min(...err);
    if (err[0] === lowest || err[err.length - 1] === lowest) return { xi: NaN, refusal: "Err has no minimum near the closed form" };
    const chosen = against(curve, setting, model, step, steps);
    let [best, least] = [NaN, Infinity];
    for (let i = 1; i < trial.length - 1; i += 1) {
      if (!(err[i] < err[i - 1] && err[i] <= err[i + 1] && err[i] <= rivals * lowest)) continue;
      const xi = integralMinimum(chosen, step, trial[i]);
      const value = chosen(xi).err;
      if (value < least) [best, least] = [xi, value];
    }
    const finest = against(curve, setting, model, step / refinement, steps * refinement);
    return { xi: integralMinimum(finest, step / refinement, best), refusal: "" };
  }

  return { search };
}

if (typeof module !== "undefined") module.exports = leastError;
