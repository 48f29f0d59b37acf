"use strict";
// The damping ratio of least Err from the table of rockdamp/equivalence/tabulated.py, of which the page's data hold the part with a3 = 1:
// read as `damping_ratio_table` reads it, or refused as `table_refusal` refuses. Tests hold both against each other.

function ratioTable(given) {
  const bytes = (text) => Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
  const tables = Object.fromEntries(Object.entries(given.models).map(([model, { nodes, units, refused }]) => {
    const whole = new DataView(bytes(units).buffer);
    const bits = bytes(refused);
    const value = (node) => whole.getInt16(2 * node, true) * given.unit;
    return [model, { nodes, value, refuses: (cell) => (bits[cell >> 3] & (128 >> cell % 8)) !== 0 }];
  }));
  const part = (value, [low, high]) => (value - low) / (high - low);
  const within = (at) => at >= -given.rounding && at <= 1 + given.rounding;

  // e, a1, b1 and the release from 0 to 1 over their ranges, of the curve of a3 = 1 that stands for one of translated softening.
  function unit({ e, a1, b1, a3, softening, x0 }) {
    const scale = softening === "translated" ? a3 : 1;
    const [slack, plateau, from] = [a1 / scale, b1 / scale, x0 / scale];
    const stiffest = 1 / (1 / (1 - plateau) + given.room);
    const least = given.release[0] + given.release[1] * slack;
    return [
      part(e, given.e),
      Math.log(slack / given.least_a1) / Math.log(stiffest / given.least_a1),
      part(plateau, given.b1),
      part(from, [least, given.release[2]]),
    ];
  }

  // The cubic through the four nodes nearest to a place among so many: the first of them, and the weight of each.
  function cubic(place, count) {
    const first = Math.min(Math.max(Math.trunc(place) - 1, 0), count - 4);
    const s = place - first;
    const weights = [
      (-(s - 1) * (s - 2) * (s - 3)) / 6, (s * (s - 2) * (s - 3)) / 2, (-s * (s - 1) * (s - 3)) / 2, (s * (s - 1) * (s - 2)) / 6,
    ];
    return { first, weights };
  }

  function between({ nodes, value }, at) {
    const axes = nodes.map((count, axis) => cubic(at[axis] * (count - 1), count));
    const sum = (axis, start) => {
      if (axis === nodes.length) return value(start);
      const { first, weights } = axes[axis];
      return weights.reduce((total, weight, k) => total + weight * sum(axis + 1, start * nodes[axis] + first + k), 0);
    };
    return sum(0, 0);
  }

  // xi and an empty text, or no xi and why.
  function read(model, setting) {
    const at = unit(setting);
    const [e, a1, b1, x0] = at.map(within);
    const a3 = setting.softening === "translated" || setting.a3 === 1;
    const outside = [e, b1, a3, a1, x0].indexOf(false);
    if (outside >= 0) return { xi: NaN, refusal: given.refusals[outside] };
    const kept = at.map((place) => Math.min(Math.max(place, 0), 1));
    const table = tables[model];
    const cell = table.nodes.reduce((all, count, axis) => all * (count - 1) + Math.min(Math.trunc(kept[axis] * (count - 1)), count - 2), 0);
    if (table.refuses(cell)) return { xi: NaN, refusal: given.refusals[given.refusals.length - 1] };
    const delta = -Math.log(setting.e);
    return { xi: (delta / Math.hypot(Math.PI, delta)) * Math.exp(between(table, kept)), refusal: "" };
  }

  return { read };
}

if (typeof module !== "undefined") module.exports = ratioTable;
