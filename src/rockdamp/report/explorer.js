"use strict";
// The explorer: sliders, the curve and the dampers by the closed form, and decays looked up in what was stored.

(function () {
  const data = JSON.parse(document.getElementById("explorer-data").textContent);
  const form = closedForm(data.constants);
  const state = { ...data.start };
  const find = (id) => document.getElementById(id);
  const inputs = [...document.querySelectorAll("#explorer-controls [data-name]")];
  const steps = Object.fromEntries(inputs.map((input) => [input.dataset.name, Number(input.dataset.step)]));
  const viscous = data.models.filter((model) => model !== data.reference);
  const plain = (value) => String(Number(value.toPrecision(6)));

  // --- stored decays ----------------------------------------------------------------------------------------------

  const bytes = Uint8Array.from(atob(data.decays.displacement), (character) => character.charCodeAt(0));
  const stored = new DataView(bytes.buffer);
  const tau = Array.from({ length: data.decays.points }, (_, i) => i * data.decays.spacing);

  function decay(model, amplitude, restitution) {
    const { releases, restitutions, points, missing, scale } = data.decays;
    const start = ((model * releases.length + amplitude) * restitutions.length + restitution) * points;
    return tau.map((_, i) => {
      const value = stored.getInt16(2 * (start + i), true);
      return value === missing ? NaN : value * scale;
    });
  }

  const nearest = (values, wanted) =>
    values.reduce((best, value, i) => (Math.abs(value - wanted) < Math.abs(values[best] - wanted) ? i : best), 0);

  // --- plots ------------------------------------------------------------------------------------------------------

  function plot(id, title, x, y, xs, ys) {
    const range = (ends) => (ends ? new Bokeh.Range1d({ start: ends[0], end: ends[1] }) : new Bokeh.DataRange1d());
    const figure = Bokeh.Plotting.figure({
      title, height: 270, sizing_mode: "stretch_width", tools: "",
      x_range: range(xs), y_range: range(ys), x_axis_label: x, y_axis_label: y,
      toolbar_location: null, min_border_right: 15, // without tools a finger that scrolls is not caught here
    });
    for (const axis of [figure.xaxis, figure.yaxis].flat()) axis.axis_label_text_font_style = "normal";
    figures.push([figure, id]);
    return figure;
  }

  function line(figure, options = {}) {
    const source = new Bokeh.ColumnDataSource({ data: { x: [], y: [] } });
    figure.line({ field: "x" }, { field: "y" }, { source, line_color: "#1A1A1A", line_width: 2, ...options });
    return source;
  }

  function dot(figure, color) {
    const source = new Bokeh.ColumnDataSource({ data: { x: [], y: [] } });
    figure.scatter({ field: "x" }, { field: "y" }, { source, size: 8, line_color: color, fill_color: color });
    return source;
  }

  const look = (model) => ({ line_color: data.styles[model].colour, line_dash: data.styles[model].dash });
  const each = (models, make) => Object.fromEntries(models.map((model) => [model, make(model)]));
  const figures = [];
  const u = "displacement u/u_ins";
  const curvePlot = plot("plot-curve", "Force-displacement curve", u, "force F/F0", [0, 1], [0, 1.02]);
  line(curvePlot, { line_color: "#6E6E6E", line_width: 1, line_dash: [4, 3] }).data = { x: [0, 1], y: [1, 0] };
  const curveLine = line(curvePlot);
  const release = dot(curvePlot, "#1A1A1A");
  const lawPlot = plot("plot-laws", "Damping coefficient at these ξ", u, "C/(m_eff p)", [0, 1]);
  const laws = each(viscous, (model) => line(lawPlot, look(model)));
  const ratioPlot = plot("plot-ratios", "ξ against release amplitude", "release u0/u_ins", "damping ratio ξ", [0, 1]);
  const ratios = each(viscous, (model) => line(ratioPlot, look(model)));
  const marks = each(viscous, (model) => dot(ratioPlot, data.styles[model].colour));
  const last = tau[tau.length - 1];
  const decayPlot = plot("plot-decays", "Stored decays", "dimensionless time τ = p t", "u/u_ins", [0, last]);
  decayPlot.add_layout(new Bokeh.Span({ // Eq. (17) sums up to here
    location: data.decays.window, dimension: "height", line_color: "#6E6E6E", line_dash: [2, 3],
  }));
  const decays = each(data.models, (model) => line(decayPlot, { ...look(model), line_width: 1.5 }));

  // --- from the state to the page ---------------------------------------------------------------------------------

  const grid = (end, count) => Array.from({ length: count }, (_, i) => (end * (i + 1)) / (count + 1));

  function drawCurve(curve) {
    curveLine.data = { x: [0, curve.a1, curve.a2, curve.a3, 1], y: [0, curve.b1, curve.b1, 0, 0] };
    release.data = { x: [state.x0], y: [form.force(curve, state.x0)] };
  }

  function drawDampers(curve) {
    const x = [...grid(curve.a3, 240), curve.a1, curve.a2].sort((one, other) => one - other);
    const releases = grid(curve.a3, 60);
    for (const model of viscous) {
      const xi = form.dampingRatio(curve, model, state.e, state.x0);
      const law = (at) => xi * form.coefficient(curve, model, at, form.speedAt(curve, at, state.x0));
      laws[model].data = { x, y: x.map(law) };
      ratios[model].data = { x: releases, y: releases.map((x0) => form.dampingRatio(curve, model, state.e, x0)) };
      marks[model].data = { x: [state.x0], y: [xi] };
      find(`xi-${model}`).textContent = xi.toFixed(6);
    }
    find("xi-eq15").textContent = form.gianniniMasiani(state.e).toFixed(6);
  }

  function drawDecays() {
    const { releases, restitutions, ratios: matched } = data.decays;
    const i = nearest(releases, state.x0);
    const j = nearest(restitutions, state.e);
    data.models.forEach((model, index) => {
      decays[model].data = { x: tau, y: decay(index, i, j) };
      const cell = find(`matched-${model}`);
      if (cell) cell.textContent = matched[index][i][j].toFixed(4);
    });
    const own = data.decays.curve;
    const same = ["a1", "b1", "a3"].every((name) => Math.abs(own[name] - state[name]) < 1e-9);
    find("explorer-grid").textContent =
      `Shown: u0/u_ins = ${plain(releases[i])} and e = ${plain(restitutions[j])}, the nearest of the stored decays. ` +
      `They are those of the study's curve, a1 = ${plain(own.a1)}, b1 = ${plain(own.b1)}, a3 = ${plain(own.a3)}` +
      `${same ? "." : ": not the curve set above, for which nothing is stored."}`;
  }

  function show(messages) {
    const curve = form.curve(state);
    drawCurve(curve);
    drawDampers(curve);
    drawDecays();
    for (const input of inputs) input.value = input.type === "number" ? plain(state[input.dataset.name]) : state[input.dataset.name];
    find("explorer-softening").value = state.softening;
    find("explorer-message").textContent = messages.join(" ");
    find("explorer-message").hidden = messages.length === 0;
  }

  // --- from the reader to the state -------------------------------------------------------------------------------

  function keep(name, messages) {
    const wanted = state[name];
    const { words } = form.limits(name, state);
    state[name] = form.clamp(name, wanted, steps[name], state);
    if (state[name] !== wanted) {
      const label = name === "x0" ? "u0/u_ins" : name;
      messages.push(`${label} is ${plain(wanted)}; it must be ${words}. Shown: ${plain(state[name])}.`);
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
      messages.push(`${name === "x0" ? "u0/u_ins" : name} must be a number, ${words}. Shown: ${plain(state[name])}.`);
    }
    if (name !== "x0") keep("x0", messages); // the release follows where the curve now ends before it
    show(messages);
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
  });
  for (const button of document.querySelectorAll("#explorer-presets button")) {
    button.addEventListener("click", () => {
      const messages = [];
      Object.assign(state, data.presets[button.dataset.preset]);
      keep("x0", messages);
      show(messages);
    });
  }

  show([]);
  find("explorer").classList.add("ready");
  for (const [figure, id] of figures) Bokeh.Plotting.show(figure, find(id));
})();
