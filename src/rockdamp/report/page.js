"use strict";
// The first screen by its slider, and links that open what they point to.

(function () {
  const slider = document.getElementById("answer-e");
  const answer = document.getElementById("answer").dataset;

  // The damping ratio of least Err at e, between those of the neighbouring e of the study.
  function leastError(model, e) {
    const least = JSON.parse(answer.ratios);
    const ratio = least.ratio[model];
    if (!ratio) return "–";
    const above = Math.max(1, least.e.findIndex((one) => one >= e));
    const [low, high] = [least.e[above - 1], least.e[above]];
    return (100 * (ratio[above - 1] + ((ratio[above] - ratio[above - 1]) * (e - low)) / (high - low))).toFixed(2);
  }

  // ξ of the slider's e, and what the study of earthquakes has at its e nearest to that.
  function tell() {
    const e = Number(slider.value);
    document.getElementById("answer-shown").textContent = slider.value;
    for (const cell of document.querySelectorAll("#answer [data-model]")) cell.textContent = leastError(cell.dataset.model, e);
    const off = JSON.parse(answer.e).map((studied) => Math.abs(Number(studied) - e));
    const nearest = off.indexOf(Math.min(...off));
    document.getElementById("answer-nearest").textContent = off[nearest] > 1e-9 ? `, the nearest studied to ${slider.value}` : "";
    for (const part of document.querySelectorAll("[data-by-e]")) part.textContent = JSON.parse(part.dataset.byE)[nearest];
  }

  if (slider) slider.addEventListener("input", tell);

  // What a link points to may be folded.
  function reveal() {
    const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (!target) return;
    for (let part = target; part; part = part.parentElement) if (part.tagName === "DETAILS") part.open = true;
    target.scrollIntoView();
  }

  addEventListener("hashchange", reveal);
  addEventListener("load", reveal); // the pictures have their sizes now
})();
