"use strict";
// The closed form of rockdamp/equivalence/closed_form.py and the curve's limits of rockdamp/mechanics/curve.py, in the reader's browser. Nodes,
// weights and tolerances come from there with the page's data; tests hold both against each other.

function closedForm(constants) {
  const { nodes, weights, plateau_pieces: pieces, rounding, exact } = constants;
  const firstOrder = 2 ** -40; // a damping ratio so small that its loss is of first order, and no bit is lost

  function curve({ a1, b1, a3, softening }) {
    const a2 = (softening === "steeper" ? 1 : a3) - b1;
    const k1 = b1 / a1;
    return { a1, b1, a2, a3, k1, ks: b1 / (a3 - a2), w1: Math.sqrt(k1) };
  }

  function force(c, x) {
    return Math.max(Math.min(c.k1 * x, c.b1, c.ks * (c.a3 - x)), 0);
  }

  function energy(c, x) {
    const z1 = Math.min(x, c.a1);
    const z2 = Math.min(Math.max(x, c.a1), c.a2);
    const z3 = Math.min(Math.max(x, c.a2), c.a3);
    return (c.k1 * z1 * z1 + 2 * c.b1 * (z2 - c.a1) + c.ks * (z3 - c.a2) * (2 * c.a3 - c.a2 - z3)) / 2;
  }

  // C over m_eff p by the formula in the damper's file, of which the page makes `dampingFormulas`; of a damper without one it is no number,
  // and no curve is drawn. The speed, away from x = 0, matters to dampers of an order above 0 alone.
  function coefficient(c, model, x, speed = 0, xi = 1) {
    const z = Math.max(x, 1e-100);
    const { order, normalisation } = exact[model] ?? {};
    return dampingFormulas[model]?.(z, force(c, z), 2 * energy(c, z), speed, c.w1, order, normalisation, xi) ?? NaN;
  }

  // g(x0; a1, b1, a3): branch by branch in s = sqrt(x0 - x), by Gauss and Legendre's rule.
  function factor(c, model, x0) {
    const ends = [0];
    for (let piece = 0; piece <= pieces; piece += 1) {
      ends.push(Math.min(c.a1 * (c.a2 / c.a1) ** (piece / pieces), x0));
    }
    ends.push(x0);
    const v0 = energy(c, x0);
    let work = 0;
    for (let i = 1; i < ends.length; i += 1) {
      const s0 = Math.sqrt(x0 - ends[i]);
      const s1 = Math.sqrt(x0 - ends[i - 1]);
      for (let j = 0; j < nodes.length && s1 > s0; j += 1) {
        const s = (s0 + s1) / 2 + ((s1 - s0) / 2) * nodes[j];
        const x = x0 - s * s;
        const speed = speedAt(c, x, x0);
        work += ((s1 - s0) / 2) * weights[j] * 2 * s * coefficient(c, model, x, speed, firstOrder) * speed;
      }
    }
    return (v0 * firstOrder) / work;
  }

  // The speed at x of the half cycle that starts at x0 and loses nothing.
  function speedAt(c, x, x0) {
    return Math.sqrt(Math.max(2 * (energy(c, x0) - energy(c, x)), 0));
  }

  // The order of ECD, a whole number, with N_m = (sqrt(pi)/2) Gamma(m + 2)/Gamma(m + 3/2).
  function setOrder(order) {
    let normalisation = 1;
    for (let j = 0; j < order; j += 1) normalisation *= (j + 2) / (j + 1.5);
    exact.ECD = { order, normalisation };
  }

  function dampingRatio(c, model, e, x0) {
    const delta = 0 - Math.log(e);
    if (!(model in exact)) return delta * factor(c, model, x0);
    return delta / (exact[model].order === 0 ? Math.hypot(Math.PI, delta) : Math.PI);
  }

  function gianniniMasiani(e) {
    return (2 * (1 - e)) / (Math.PI * (1 + e));
  }

  // What a parameter may be while the others stay: both ends, whether the upper one belongs to it, and in words.
  function limits(name, { a1, b1, a3, softening, t, h }) {
    const steeper = softening === "steeper";
    if (name === "e") return { low: 0, high: 1, closed: true, words: "greater than 0 and at most 1" };
    if (name === "m") return { low: -1, high: 32, closed: true, words: "a whole number from 0 to 32" };
    if (name === "t") return { low: 0, high: h / 4, closed: true, words: "greater than 0 and at most a quarter of the height" };
    if (name === "h") return { low: 4 * t, high: 20, closed: true, words: "greater than 4 t and at most 20 m" };
    if (name === "x0") return { low: 0, high: a3, closed: false, words: "greater than 0 and less than a3" };
    if (name === "a1") {
      const words = `greater than 0 and less than a2, where the plateau ends (${steeper ? "1" : "a3"} − b1)`;
      return { low: 0, high: (steeper ? 1 : a3) - b1, closed: false, words };
    }
    if (name === "b1") {
      if (steeper) return { low: 1 - a3, high: 1 - a1, closed: false, words: "greater than 1 − a3 and less than 1 − a1" };
      return { low: 0, high: a3 - a1, closed: false, words: "greater than 0 and less than a3 − a1" };
    }
    const words = `greater than ${steeper ? "1 − b1" : "a1 + b1"} with ${softening} softening and at most 1`;
    return { low: steeper ? 1 - b1 : a1 + b1, high: 1, closed: true, words };
  }

  // The allowed value next to the one wanted: a whole number of steps where the room has one, else its middle.
  function clamp(name, wanted, step, values) {
    const { low, high, closed } = limits(name, values);
    if (name === "m") return Math.max(0, Math.min(high, Math.round(wanted)));
    const inside = (value) =>
      value > low + rounding && (closed ? value <= high : value < high - rounding);
    if (inside(wanted)) return wanted;
    const decimals = Math.max(0, Math.ceil(-Math.log10(step)));
    const start = wanted > low ? Math.floor(high / step) + 1 : Math.floor(low / step) - 1;
    const way = wanted > low ? -1 : 1;
    for (let k = 0; k < 4; k += 1) {
      const value = Number(((start + way * k) * step).toFixed(decimals));
      if (inside(value)) return value;
    }
    return (low + high) / 2;
  }

  return { exact: (model) => model in exact, curve, force, energy, coefficient, speedAt, factor, dampingRatio, gianniniMasiani, limits, clamp, setOrder };
}

if (typeof module !== "undefined") module.exports = closedForm;
