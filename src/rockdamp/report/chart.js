"use strict";
// Line charts as SVG. Their colours follow the page's, light or dark; the text keeps its size whatever the width.

const SVG = "http://www.w3.org/2000/svg";

function element(tag, attributes, parent, text) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text !== undefined) made.textContent = text;
  if (parent) parent.append(made);
  return made;
}

// Round numbers from low to high, about as many as wanted.
function ticks(low, high, wanted) {
  const rough = (high - low) / wanted;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find((factor) => factor * power >= rough * 0.999) * power;
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1) found.push((k * step).toFixed(decimals));
  return found;
}

// A chart in an element: `draw` takes lines {x, y, colour, dash, width} and dots {x, y, colour}; ends of an axis that are not given fit them.
function chart(place, { title, x: xLabel, y: yLabel, height = 270 }) {
  let shown = null;

  function ends(axis, given, lines) {
    if (given) return given;
    let [low, high] = [Infinity, -Infinity];
    for (const line of lines) for (const value of line[axis]) {
      if (value < low) low = value;
      if (value > high) high = value;
    }
    if (!(high > low)) [low, high] = [Math.min(low, 0), Math.max(high, 1)];
    return Number.isFinite(low) && Number.isFinite(high) ? [low < 0 ? low - 0.03 * (high - low) : low, high + 0.03 * (high - low)] : [0, 1];
  }

  function render() {
    const width = Math.max(place.clientWidth, 240);
    const [left, right, top, bottom] = [58, width - 12, 30, height - 44];
    const { lines, dots = [], spans = [], xs, ys } = shown;
    const [x0, x1] = ends("x", xs, lines);
    const [y0, y1] = ends("y", ys, lines);
    const px = (value) => left + ((value - x0) / (x1 - x0)) * (right - left);
    const py = (value) => bottom - ((value - y0) / (y1 - y0)) * (bottom - top);
    const svg = element("svg", { viewBox: `0 0 ${width} ${height}`, width, height, "aria-hidden": "true" });
    const id = `${place.id}-inside`;
    const clip = element("clipPath", { id }, svg);
    element("rect", { x: left, y: top, width: right - left, height: bottom - top }, clip);
    element("text", { x: left, y: 16, class: "chart-title" }, svg, title);
    for (const tick of ticks(x0, x1, Math.max(3, width / 90))) {
      element("line", { x1: px(tick), x2: px(tick), y1: top, y2: bottom, class: "grid" }, svg);
      element("text", { x: px(tick), y: bottom + 17, "text-anchor": "middle" }, svg, tick.replace("-", "−"));
    }
    for (const tick of ticks(y0, y1, 5)) {
      element("line", { x1: left, x2: right, y1: py(tick), y2: py(tick), class: "grid" }, svg);
      element("text", { x: left - 6, y: py(tick) + 4, "text-anchor": "end" }, svg, tick.replace("-", "−"));
    }
    element("text", { x: (left + right) / 2, y: height - 8, "text-anchor": "middle" }, svg, xLabel);
    const turned = { transform: `translate(13 ${(top + bottom) / 2}) rotate(-90)`, "text-anchor": "middle" };
    element("text", turned, svg, yLabel);
    const inside = element("g", { "clip-path": `url(#${id})` }, svg);
    for (const at of spans) element("line", { x1: px(at), x2: px(at), y1: top, y2: bottom, class: "span" }, inside);
    for (const { x, y, colour, dash = [], width: stroke = 2 } of lines) {
      let path = "";
      let pen = "M";
      for (let i = 0; i < x.length; i += 1) {
        if (!Number.isFinite(y[i])) {
          pen = "M"; // a gap
          continue;
        }
        path += `${pen}${px(x[i]).toFixed(1)} ${py(y[i]).toFixed(1)}`;
        pen = "L";
      }
      const look = { d: path, class: "line", "stroke-width": stroke, "stroke-dasharray": dash.join(" ") };
      element("path", look, inside).style.setProperty("--colour", colour);
    }
    for (const { x, y, colour } of dots) {
      element("circle", { cx: px(x), cy: py(y), r: 4.5, class: "dot" }, inside).style.setProperty("--colour", colour);
    }
    place.replaceChildren(svg);
  }

  addEventListener("resize", () => shown && render());
  return {
    draw(what) {
      shown = what;
      render();
    },
  };
}
