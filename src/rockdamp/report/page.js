"use strict";
// Two sliders, e and a1, set the damping ratios of the table, which are interpolated between those of the study. The errors
// are those at the nearest e of the study.

(function () {
  const table = document.getElementById("programs");
  if (!table || !table.dataset.ratios) return;
  const stored = JSON.parse(table.dataset.ratios);
  const studied = JSON.parse(table.dataset.studied);
  const sliders = { e: document.getElementById("slider-e"), a1: document.getElementById("slider-a1") };

  // Return the neighbours of a value in a grid, and the fraction of the way from the lower to the upper.
  function locate(grid, value) {
    let low = 0;
    while (low < grid.length - 2 && grid[low + 1] <= value) low += 1;
    const high = Math.min(low + 1, grid.length - 1);
    if (high === low) return { low, high, fraction: 0 };
    return { low, high, fraction: (value - grid[low]) / (grid[high] - grid[low]) };
  }

  function interpolate(row, place) {
    return row[place.low] + place.fraction * (row[place.high] - row[place.low]);
  }

  // The damping ratio of least error, linear in e and in a1. [%]
  function dampingRatio(model, e, a1) {
    const rows = stored.ratio[model];
    if (!rows) return "–";
    const placeOfE = locate(stored.e, e);
    const ratiosByA1 = rows.map((row) => interpolate(row, placeOfE));
    return (100 * interpolate(ratiosByA1, locate(stored.a1, a1))).toFixed(2);
  }

  function show() {
    const e = Number(sliders.e.value);
    const a1 = Number(sliders.a1.value);
    document.getElementById("shown-e").textContent = sliders.e.value;
    document.getElementById("shown-a1").textContent = sliders.a1.value;
    for (const cell of table.querySelectorAll("[data-model]")) {
      cell.textContent = dampingRatio(cell.dataset.model, e, a1);
    }
    const distances = studied.map((value) => Math.abs(value - e));
    const nearest = distances.indexOf(Math.min(...distances));
    for (const cell of table.querySelectorAll("[data-by-e]")) {
      cell.textContent = JSON.parse(cell.dataset.byE)[nearest];
    }
  }

  for (const slider of Object.values(sliders)) slider.addEventListener("input", show);
})();
