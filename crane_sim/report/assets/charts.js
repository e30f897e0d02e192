"use strict";
// Charts over time and paths in the plane, as SVG.

const SVG = "http://www.w3.org/2000/svg";
const TEXT_WIDTH = 6.4; // px of a digit, at most
const PLAIN = { left: 54, right: 10, top: 8, bottom: 32, height: 190 };

function element(name, attributes = {}, parent = null, text = "") {
  const node = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  if (text) node.textContent = text;
  if (parent) parent.append(node);
  return node;
}

function html(name, parent, text = "", attributes = {}) {
  const node = document.createElement(name);
  Object.assign(node, attributes);
  if (text) node.textContent = text;
  parent.append(node);
  return node;
}

// Return about `count` round numbers from low to high.
function ticks(low, high, count) {
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5, 10].find((factor) => factor * power >= rough * 0.999) ?? 10);
  const numbers = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) numbers.push(k * step);
  return { numbers, step, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
}

// Return the text of a number between ticks `step` apart, on an axis up to `size`: as many digits as tell ticks apart.
function tickText(value, step, digits, size) {
  if (Math.abs(value) < 1e-9 * step) return "0";
  const places = Math.max(0, Math.floor(Math.log10(Math.abs(value)) + 1e-9) - Math.floor(Math.log10(step) + 1e-9));
  return size >= 1e5 || size < 1e-3 ? value.toExponential(Math.min(places, 6)) : value.toFixed(Math.min(digits, 9));
}

function spread(low, high) {
  if (!(high >= low)) return [-1, 1];
  const size = Math.max(Math.abs(low), Math.abs(high)), still = high - low <= 1e-6 * size || high - low < 1e-9;
  const margin = still ? 0.5 * size || 1 : 0.06 * (high - low);
  return [low - margin, high + margin];
}

class Axes {
  constructor(svg, width, height, x, y, labels) {
    const box = PLAIN, up = ticks(...y, Math.max(3, Math.round((height - box.top - box.bottom) / 38)));
    const size = Math.max(...y.map(Math.abs)), texts = up.numbers.map((value) => tickText(value, up.step, up.digits, size));
    const left = Math.max(box.left, 26 + TEXT_WIDTH * Math.max(...texts.map((text) => text.length)));
    Object.assign(this, { x, y, left, top: box.top, width: width - left - box.right, height: height - box.top - box.bottom });
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    svg.setAttribute("height", height);
    const grid = element("g", { stroke: "#e3e7eb" }, svg);
    const across = ticks(...x, Math.max(3, Math.round(this.width / 80)));
    up.numbers.forEach((value, i) => {
      element("line", { x1: this.left, x2: this.left + this.width, y1: this.py(value), y2: this.py(value) }, grid);
      const place = { x: this.left - 6, y: this.py(value) + 4, "text-anchor": "end" };
      element("text", place, svg, texts[i]);
    });
    for (const value of across.numbers) {
      element("line", { x1: this.px(value), x2: this.px(value), y1: this.top, y2: this.top + this.height }, grid);
      element("text", { x: this.px(value), y: this.top + this.height + 15, "text-anchor": "middle" }, svg, value.toFixed(across.digits));
    }
    element("text", { x: this.left + this.width, y: height - 3, "text-anchor": "end" }, svg, labels[0]);
    const middle = this.top + this.height / 2;
    element("text", { x: 11, y: middle, transform: `rotate(-90 11 ${middle})`, "text-anchor": "middle" }, svg, labels[1]);
  }

  px(value) {
    return this.left + ((value - this.x[0]) / (this.x[1] - this.x[0])) * this.width;
  }

  py(value) {
    return this.top + (1 - (value - this.y[0]) / (this.y[1] - this.y[0])) * this.height;
  }

  path(x, y) {
    let text = "", drawn = false;
    for (let i = 0; i < x.length; i++) {
      if (!Number.isFinite(y[i])) drawn = false;
      else {
        text += `${drawn ? "L" : "M"}${this.px(x[i]).toFixed(1)} ${this.py(y[i]).toFixed(1)}`;
        drawn = true;
      }
    }
    return text;
  }
}

class Chart {
  constructor(parent, panel, events, seek) {
    this.panel = panel;
    this.events = events;
    this.curves = panel.curves.map((curve) => ({ ...curve, t: decodeFloats(curve.t), values: decodeFloats(curve.values) }));
    this.figure = html("figure", parent);
    const caption = html("figcaption", this.figure, panel.title);
    const legend = html("div", caption, "", { className: "legend" });
    this.values = this.curves.map((curve) => {
      const entry = html("span", legend), line = html("b", entry, "", { className: curve.dotted ? "dotted" : curve.dashed ? "dashed" : "" });
      line.style.borderTopColor = curve.color;
      entry.append(`${curve.name} `);
      return html("span", entry);
    });
    this.svg = element("svg", { role: "img", "aria-label": panel.title }, this.figure);
    const pointed = (event) => {
      if (event.buttons !== 1 && event.type !== "pointerdown") return;
      const { left, width } = this.svg.getBoundingClientRect(), { axes } = this;
      const across = ((event.clientX - left) / width) * this.width;
      seek(axes.x[0] + ((across - axes.left) / axes.width) * (axes.x[1] - axes.x[0]));
    };
    this.svg.addEventListener("pointerdown", pointed);
    this.svg.addEventListener("pointermove", pointed);
  }

  draw(width, range) {
    this.width = width;
    this.svg.replaceChildren();
    let low = Infinity, high = -Infinity;
    for (const { values } of this.curves) for (const value of values) {
      if (value < low) low = value;
      if (value > high) high = value;
    }
    this.axes = new Axes(this.svg, width, PLAIN.height, range, spread(low, high), ["time [s]", `[${this.panel.unit}]`]);
    const { axes } = this;
    for (const [t] of this.events) if (t >= range[0] && t <= range[1])
      element("line", { x1: axes.px(t), x2: axes.px(t), y1: axes.top, y2: axes.top + axes.height, stroke: "#d9730d", "stroke-opacity": 0.35 }, this.svg);
    for (const curve of this.curves)
      element("path", { d: axes.path(curve.t, curve.values), fill: "none", stroke: curve.color, "stroke-width": curve.dashed ? 1.2 : 1.6,
        "stroke-dasharray": curve.dotted ? "1.5 2" : curve.dashed ? "5 4" : "none", "stroke-linejoin": "round" }, this.svg);
    this.cursor = element("line", { y1: axes.top, y2: axes.top + axes.height, stroke: "#1f2933", "stroke-width": 1 }, this.svg);
  }

  show(t) {
    const { axes } = this, x = axes.px(Math.min(Math.max(t, axes.x[0]), axes.x[1]));
    this.cursor.setAttribute("x1", x);
    this.cursor.setAttribute("x2", x);
    this.curves.forEach((curve, i) => {
      const value = interpolate(curve.t, curve.values, t);
      this.values[i].textContent = Number.isFinite(value) ? format(value) : "–";
    });
  }
}

// Bands of states over time, one row a timeline; a click on a band goes to its beginning.
class StateChart {
  constructor(parent, rows, seek) {
    Object.assign(this, { rows, seek, pitch: 22 });
    this.figure = html("figure", parent, "", { className: "wide" });
    html("figcaption", this.figure, "States");
    this.svg = element("svg", { role: "img", "aria-label": "States" }, this.figure);
  }

  draw(width, range) {
    this.svg.replaceChildren();
    const longest = Math.max(...this.rows.map((row) => row.name.length)), rowHeight = this.pitch;
    const left = Math.min(TEXT_WIDTH * longest + 12, 0.4 * width), height = rowHeight * this.rows.length + 34;
    const right = width - PLAIN.right, px = (t) => left + ((t - range[0]) / (range[1] - range[0])) * (right - left);
    Object.assign(this, { range, px, bottom: height - 32 });
    this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.svg.setAttribute("height", height);
    this.rows.forEach((row, i) => this.drawRow(row, i * rowHeight, left));
    for (const value of ticks(...range, Math.max(3, Math.round((right - left) / 90))).numbers)
      element("text", { x: px(value), y: height - 17, "text-anchor": "middle" }, this.svg, String(Number(value.toPrecision(6))));
    element("text", { x: right, y: height - 3, "text-anchor": "end" }, this.svg, "time [s]");
    this.cursor = element("line", { y1: 0, y2: this.bottom, stroke: "#1f2933", "stroke-width": 1 }, this.svg);
  }

  drawRow(row, top, left) {
    const text = element("text", { x: left - 6, y: top + 14, "text-anchor": "end" }, this.svg, row.name);
    if (text.getComputedTextLength?.() > left - 8) text.setAttribute("textLength", left - 8);
    for (const [begin, end, state, color] of row.spans) {
      const first = Math.max(begin, this.range[0]), last = Math.min(end, this.range[1]);
      if (last < first || (last === first && begin !== end)) continue;
      const x = this.px(first), width = Math.max(1, this.px(last) - x);
      const band = element("rect", { x, y: top + 2, width, height: this.pitch - 5, fill: color }, this.svg);
      element("title", {}, band, `${row.name}: ${state}, ${begin.toFixed(3)} .. ${end.toFixed(3)} s`);
      band.addEventListener("click", () => this.seek(begin));
      if (width > TEXT_WIDTH * state.length + 6)
        element("text", { x: x + 4, y: top + 14, class: color === "#c3cad1" ? "band normal" : "band" }, this.svg, state);
    }
  }

  show(t) {
    const x = this.px(Math.min(Math.max(t, this.range[0]), this.range[1]));
    this.cursor.setAttribute("x1", x);
    this.cursor.setAttribute("x2", x);
  }
}

class PathChart {
  constructor(parent, frames, title, across, up) {
    const [first, count] = frames.parts.nodes, column = (k) => frames.columns[first + count - 3 + k];
    Object.assign(this, { frames, x: column(across), y: column(up), labels: [`${"xyz"[across]} [m]`, `${"xyz"[up]} [m]`] });
    this.figure = html("figure", parent);
    html("figcaption", this.figure, title);
    this.svg = element("svg", { role: "img", "aria-label": title }, this.figure);
  }

  draw(width) {
    this.svg.replaceChildren();
    const height = 1.3 * PLAIN.height;
    const [x, y] = sameScale(limits(this.x), limits(this.y), width - PLAIN.left - PLAIN.right, height - PLAIN.top - PLAIN.bottom);
    this.axes = new Axes(this.svg, width, height, x, y, this.labels);
    element("path", { d: this.axes.path(this.x, this.y), fill: "none", stroke: "#c8332b", "stroke-width": 1.4, "stroke-opacity": 0.7 }, this.svg);
    element("circle", { cx: this.axes.px(this.x[0]), cy: this.axes.py(this.y[0]), r: 3, fill: "none", stroke: "#1f2933" }, this.svg);
    this.cursor = element("circle", { r: 4.5, fill: "#c8332b", stroke: "#fff" }, this.svg);
  }

  show(t) {
    const [row, share] = this.frames.locate(t);
    const at = (column) => column[row] + (share ? share * (column[row + 1] - column[row]) : 0);
    this.cursor.setAttribute("cx", this.axes.px(at(this.x)));
    this.cursor.setAttribute("cy", this.axes.py(at(this.y)));
  }
}

function limits(values) {
  let low = Infinity, high = -Infinity;
  for (const value of values) {
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  return [low, high];
}

// Return both ranges widened so that a metre is as long along both axes.
function sameScale(x, y, width, height) {
  const perPixel = 1.1 * Math.max((x[1] - x[0]) / width, (y[1] - y[0]) / height, 1e-6);
  const widen = ([low, high], pixels) => [0.5 * (low + high - pixels * perPixel), 0.5 * (low + high + pixels * perPixel)];
  return [widen(x, width), widen(y, height)];
}

function interpolate(t, values, at) {
  let low = 0, high = t.length - 1;
  if (at <= t[0]) return values[0];
  if (at >= t[high]) return values[high];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (t[middle] <= at) low = middle;
    else high = middle;
  }
  const span = t[high] - t[low];
  return span > 0 ? values[low] + ((at - t[low]) / span) * (values[high] - values[low]) : values[low];
}

function format(value) {
  const size = Math.abs(value);
  return size !== 0 && (size < 1e-3 || size >= 1e6) ? value.toExponential(2) : value.toPrecision(4);
}
