"use strict";
// The ratios of the first card by its slider, chips that show the claims of one verdict, and links that open what they point to.

(function () {
  const data = JSON.parse(document.getElementById("explorer-data").textContent);
  const slider = document.getElementById("answer-e");

  function tell() {
    const form = closedForm(data.constants);
    const curve = form.curve(data.start);
    document.getElementById("answer-shown").textContent = slider.value;
    for (const cell of document.querySelectorAll("#answer [data-model]")) {
      const ratio = form.dampingRatio(curve, cell.dataset.model, Number(slider.value), data.start.x0);
      cell.textContent = Number.isFinite(ratio) ? (100 * ratio).toFixed(2) : "–";
    }
  }

  if (slider) slider.addEventListener("input", tell);

  const chips = [...document.querySelectorAll(".chip")];
  const groups = [...document.querySelectorAll("#claims .group")];

  // Show the claims of one verdict, or all of them.
  function show(verdict) {
    for (const chip of chips) chip.setAttribute("aria-pressed", String(chip.dataset.verdict === verdict));
    for (const group of groups) group.hidden = verdict !== null && group.id !== `verdict-${verdict}`;
  }

  for (const chip of chips) {
    chip.addEventListener("click", () => show(chip.getAttribute("aria-pressed") === "true" ? null : chip.dataset.verdict));
  }

  // What a link points to may be filtered out or folded.
  function reveal() {
    const target = document.getElementById(decodeURIComponent(location.hash.slice(1).split("?")[0]));
    if (!target) return;
    const group = target.closest("#claims .group");
    if (group && group.hidden) show(null);
    for (let part = target; part; part = part.parentElement) if (part.tagName === "DETAILS") part.open = true;
    target.scrollIntoView();
  }

  addEventListener("hashchange", reveal);
  addEventListener("load", reveal); // the pictures have their sizes, the plots now too
})();
