"use strict";
// The wall as it decays, under restitution and under the recommended damper. It moves once after each change, and not at all where the
// reader has asked for no motion: the slider of time then moves it.

function movingWall(shown, data) {
  const find = (id) => document.getElementById(id);
  const [place, button, time] = [find("wall-picture"), find("wall-play"), find("wall-time")];
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  const [width, height, ground] = [230, 250, 236];
  const svg = element("svg", { viewBox: `0 0 ${width} ${height}`, width: "100%", height, "aria-hidden": "true" }, place);
  element("line", { x1: 10, x2: width - 10, y1: ground, y2: ground, class: "support" }, svg);
  element("line", { x1: 10, x2: width - 10, y1: 14, y2: 14, class: "support" }, svg);
  const bodies = ["reference", "damper"].map((name) => element("path", { class: `wall-${name}` }, svg));
  let frame = 0;

  const { hinge } = data.wall;
  const [tall, thick] = [ground - 14, 44]; // pixels; the thickness is drawn larger than it is
  const outline = (u) => {
    const [left, bent] = [(width - thick) / 2, ground - hinge * tall];
    const moved = left + u * thick;
    return `M${left} ${ground}H${left + thick}L${moved + thick} ${bent}L${left + thick} 14H${left}L${moved} ${bent}Z`;
  };

  function stand(seconds) {
    const { reference, dampers, frequency } = shown();
    const index = Math.min(Math.round((seconds * frequency) / data.solver.step), reference.length - 1);
    bodies[0].setAttribute("d", outline(reference[index]));
    bodies[1].setAttribute("d", outline(dampers[data.recommended].x[index]));
    time.value = seconds;
    find("wall-seconds").textContent = `${seconds.toFixed(2)} s`;
  }

  const last = () => ((shown().reference.length - 1) * data.solver.step) / shown().frequency;

  function halt() {
    cancelAnimationFrame(frame);
    frame = 0;
    button.textContent = "Move";
  }

  function play(from) {
    halt();
    button.textContent = "Pause";
    let start = null;
    const advance = (now) => {
      start ??= now - 1000 * from;
      const seconds = Math.min((now - start) / 1000, last());
      stand(seconds);
      frame = seconds < last() ? requestAnimationFrame(advance) : 0;
      if (!frame) halt();
    };
    frame = requestAnimationFrame(advance);
  }

  button.addEventListener("click", () => {
    if (frame) halt();
    else play(Number(time.value) >= last() - 0.01 ? 0 : Number(time.value));
  });
  time.addEventListener("input", () => {
    halt();
    stand(Number(time.value));
  });

  function restart() {
    time.max = last().toFixed(2);
    button.hidden = still.matches;
    halt();
    stand(0);
    if (!still.matches) play(0);
  }

  still.addEventListener("change", restart);
  return { restart };
}
