"use strict";
// The explorer: sliders, the curve and the dampers by the closed form, and the decays that follow from them, all computed here.

const explorer = (function () {
  const data = JSON.parse(document.getElementById("explorer-data").textContent);
  const form = closedForm(data.constants);
  const solver = freeDecays(form);
  const searcher = leastError(form, solver, data.search);
  const state = { ...data.start };
  const find = (id) => document.getElementById(id);
  const inputs = [...document.querySelectorAll("#explorer-controls [data-name]")];
  const steps = Object.fromEntries(inputs.map((input) => [input.dataset.name, Number(input.dataset.step)]));
  const viscous = data.models.filter((model) => model !== data.reference);
  // Of a damper that only the package knows no formula is here, and nothing is drawn.
  const models = viscous.filter((model) => Number.isFinite(form.coefficient(form.curve(data.start), model, data.start.x0)));
  const plain = (value) => String(Number(value.toPrecision(6)));
  const label = (name) => (name === "x0" ? "u0/u_ins" : name);
  const grid = (end, count) => Array.from({ length: count }, (_, i) => (end * (i + 1)) / (count + 1));
  const colour = (model) => (model === data.reference ? "var(--ink)" : data.styles[model].colour);
  const look = (model) => ({ colour: colour(model), dash: data.styles[model].dash });
  const u = "displacement u/u_ins";
  const charts = {
    curve: chart(find("plot-curve"), { title: "Force-displacement curve", x: u, y: "force F/F0" }),
    laws: chart(find("plot-laws"), { title: "Damping coefficient at these ξ", x: u, y: "C/(m_eff p)" }),
    ratios: chart(find("plot-ratios"), { title: "ξ against release amplitude", x: "release u0/u_ins", y: "damping ratio ξ" }),
    decays: chart(find("plot-decays"), { title: "Decay after the release", x: "time t [s]", y: "displacement u [mm]" }),
  };
  let shown = {};

  // --- from the state to the page ---------------------------------------------------------------------------------

  function compute() {
    form.setOrder(state.m);
    const { step, steps: count, compared } = data.solver;
    const curve = form.curve(state);
    const reference = solver.decay(curve, state.x0, { e: state.e }, step, count);
    const dampers = solver.decays(state, models, step, count);
    for (const one of Object.values(dampers)) one.error = solver.rmsError(reference, one.x, compared);
    const frequency = data.wall.frequency_root_height / Math.sqrt(state.h);
    shown = { curve, reference, dampers, frequency, u_ins: data.wall.u_ins_over_thickness * state.t };
  }

  function drawCurve({ curve }) {
    const line = { x: [0, curve.a1, curve.a2, curve.a3, 1], y: [0, curve.b1, curve.b1, 0, 0], colour: "var(--ink)" };
    const bilinear = { x: [0, 1], y: [1, 0], colour: "var(--quiet)", dash: [4, 3], width: 1 };
    const release = { x: state.x0, y: form.force(curve, state.x0), colour: "var(--ink)" };
    charts.curve.draw({ lines: [bilinear, line], dots: [release], xs: [0, 1], ys: [0, 1.02] });
  }

  function drawDampers({ curve, dampers }) {
    const x = [...grid(curve.a3, 240), curve.a1, curve.a2].sort((one, other) => one - other);
    const releases = grid(curve.a3, 60);
    const law = (model) => (at) => form.coefficient(curve, model, at, form.speedAt(curve, at, state.x0), dampers[model].xi);
    charts.laws.draw({ lines: models.map((model) => ({ x, y: x.map(law(model)), ...look(model) })), xs: [0, 1] });
    const ratios = models.map((model) => ({
      x: releases, y: releases.map((x0) => form.dampingRatio(curve, model, state.e, x0)), ...look(model),
    }));
    const dots = models.map((model) => ({ x: state.x0, y: dampers[model].xi, colour: look(model).colour }));
    charts.ratios.draw({ lines: ratios, dots, xs: [0, 1] });
    for (const model of models) {
      find(`xi-${model}`).textContent = dampers[model].xi.toFixed(6);
      find(`error-${model}`).textContent = dampers[model].error.toFixed(6);
    }
    searchLeast();
    find("xi-eq15").textContent = form.gianniniMasiani(state.e).toFixed(6);
  }

  // The ratios of least Err, one damper after the other once the sliders rest: each takes some hundredths of a second.
  let search = 0;

  function searchLeast() {
    const refused = [];
    const [left, setting] = [[...models], { ...state }];
    clearTimeout(search);
    for (const model of models) find(`least-${model}`).textContent = "…";
    find("explorer-least").textContent = "";
    const next = () => {
      const model = left.shift();
      const { xi, refusal } = searcher.search(setting, model, data.solver.step, data.solver.compared);
      find(`least-${model}`).textContent = refusal ? "–" : xi.toFixed(6);
      if (refusal) refused.push(`${model}: ${refusal}.`);
      find("explorer-least").textContent = refused.join(" ");
      search = left.length ? setTimeout(next) : 0;
    };
    search = setTimeout(next, data.search.rest);
  }

  function drawDecays({ reference, dampers, frequency, u_ins: whole }) {
    const { step, drawn, compared } = data.solver;
    const every = (history) => Float64Array.from({ length: Math.floor((history.length - 1) / drawn) + 1 }, (_, i) => 1000 * whole * history[i * drawn]);
    const x = Float64Array.from(every(reference), (_, i) => (i * drawn * step) / frequency);
    const lines = models.map((model) => ({ x, y: every(dampers[model].x), width: 1.5, ...look(model) }));
    lines.unshift({ x, y: every(reference), ...look(data.reference), width: 1.5 });
    charts.decays.draw({ lines, spans: [(compared * step) / frequency], xs: [0, x[x.length - 1]] });
    find("explorer-size").textContent =
      `u_ins = ${(1000 * whole).toFixed(0)} mm, released at ${(1000 * whole * state.x0).toFixed(0)} mm; ` +
      `p = ${frequency.toPrecision(3)} rad/s: one unit of τ is ${(1 / frequency).toPrecision(3)} s.`;
  }

  function show(messages) {
    compute();
    drawCurve(shown);
    drawDampers(shown);
    drawDecays(shown);
    for (const input of inputs) input.value = input.type === "number" ? plain(state[input.dataset.name]) : state[input.dataset.name];
    find("explorer-softening").value = state.softening;
    find("explorer-message").textContent = messages.join(" ");
    find("explorer-message").hidden = messages.length === 0;
    wall.restart();
  }

  // --- from the reader to the state -------------------------------------------------------------------------------

  function keep(name, messages) {
    const wanted = state[name];
    const { words } = form.limits(name, state);
    state[name] = form.clamp(name, wanted, steps[name], state);
    if (state[name] !== wanted) {
      messages.push(`${label(name)} is ${plain(wanted)}; it must be ${words}. Shown: ${plain(state[name])}.`);
    }
  }

  function change(name, text) {
    const messages = [];
    const wanted = text.trim() === "" ? NaN : Number(text);
    if (Number.isFinite(wanted)) {
      state[name] = wanted;
      keep(name, messages);
    } else {
      const { words } = form.limits(name, state);
      messages.push(`${label(name)} must be a number, ${words}. Shown: ${plain(state[name])}.`);
    }
    if (name !== "x0") keep("x0", messages); // the release follows where the curve now ends before it
    show(messages);
    remember();
  }

  for (const input of inputs) {
    const event = input.type === "number" ? "change" : "input"; // half-typed numbers are not judged
    input.addEventListener(event, () => change(input.dataset.name, input.value));
  }
  find("explorer-softening").addEventListener("change", (event) => {
    const messages = [];
    state.softening = event.target.value;
    keep("a3", messages);
    keep("x0", messages);
    show(messages);
    remember();
  });
  for (const button of document.querySelectorAll("#explorer-presets button")) {
    button.addEventListener("click", () => {
      const messages = [];
      Object.assign(state, data.presets[button.dataset.preset]); // of the study's wall, everything
      keep("x0", messages);
      show(messages);
      remember();
    });
  }

  // --- the address, which others can be sent ----------------------------------------------------------------------

  let waiting = 0;

  function remember() {
    clearTimeout(waiting);
    const words = Object.entries(state).map(([name, value]) => `${name}=${typeof value === "number" ? plain(value) : value}`);
    waiting = setTimeout(() => history.replaceState(null, "", `#explorer?${words.join("&")}`), 200);
  }

  function recall() {
    const messages = [];
    const [place, query] = location.hash.slice(1).split("?");
    if (place !== "explorer" || query === undefined) return messages;
    const given = new URLSearchParams(query);
    for (const name of new Set(given.keys())) {
      if (!(name in state)) messages.push(`${name} in the address is none of ${Object.keys(state).join(", ")}, and is left out.`);
    }
    const softening = given.get("softening") ?? state.softening;
    if (data.softening.includes(softening)) state.softening = softening;
    else messages.push(`softening is ${softening} in the address; it must be ${data.softening.join(" or ")}. Shown: ${state.softening}.`);
    const names = [...new Set(inputs.map((input) => input.dataset.name))].filter((name) => given.has(name));
    for (const name of names) {
      const value = Number(given.get(name));
      if (given.get(name).trim() !== "" && Number.isFinite(value)) state[name] = value;
      else messages.push(`${label(name)} is not a number in the address. Shown: ${plain(state[name])}.`);
    }
    for (const name of ["a3", "b1", "a1", "e", "x0", "m", "t", "h"]) keep(name, messages);
    if (!["a1", "b1", "a3"].every((name) => form.clamp(name, state[name], steps[name], state) === state[name])) {
      for (const name of ["a1", "b1", "a3", "softening"]) state[name] = data.start[name]; // no curve at all
      messages.push("The curve in the address cannot be; the study's is shown.");
      keep("x0", messages);
    }
    return messages;
  }

  const wall = movingWall(() => shown, data);
  show(recall());
  addEventListener("hashchange", () => location.hash.startsWith("#explorer?") && show(recall()));
  find("explorer").classList.add("ready");
  return { state, data, form, solver, shown: () => shown };
})();
