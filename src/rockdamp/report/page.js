"use strict";
// Two sliders, e and a1: the damping ratios between those that the study has, and the errors at its nearest e.

(function () {
  const table = document.getElementById("programs");
  if (!table || !table.dataset.ratios) return;
  const stored = JSON.parse(table.dataset.ratios);
  const studied = JSON.parse(table.dataset.studied);
  const sliders = { e: document.getElementById("slider-e"), a1: document.getElementById("slider-a1") };

  // The neighbours of a value in a grid, and how far it is from the lower to the upper.
  function place(grid, value) {
    let low = 0;
    while (low < grid.length - 2 && grid[low + 1] <= value) low += 1;
    const high = Math.min(low + 1, grid.length - 1);
    return { low, high, part: high > low ? (value - grid[low]) / (grid[high] - grid[low]) : 0 };
  }

  function between(row, at) {
    return row[at.low] + at.part * (row[at.high] - row[at.low]);
  }

  // The damping ratio of least error, linear in e and in a1. [%]
  function dampingRatio(model, e, a1) {
    const rows = stored.ratio[model];
    if (!rows) return "–";
    const atE = place(stored.e, e);
    const byA1 = rows.map((row) => between(row, atE));
    return (100 * between(byA1, place(stored.a1, a1))).toFixed(2);
  }

  function show() {
    const [e, a1] = [Number(sliders.e.value), Number(sliders.a1.value)];
    document.getElementById("shown-e").textContent = sliders.e.value;
    document.getElementById("shown-a1").textContent = sliders.a1.value;
    for (const cell of table.querySelectorAll("[data-model]")) {
      cell.textContent = dampingRatio(cell.dataset.model, e, a1);
    }
    const apart = studied.map((value) => Math.abs(value - e));
    const nearest = apart.indexOf(Math.min(...apart));
    for (const cell of table.querySelectorAll("[data-by-e]")) cell.textContent = JSON.parse(cell.dataset.byE)[nearest];
  }

  for (const slider of Object.values(sliders)) slider.addEventListener("input", show);
})();
