// Panels of curves over one time axis, drawn by uPlot.  A zoom asks the server for the
// stretch that is seen, which then has every recorded point, or the extremes.

import uPlot from "./vendor/uPlot.esm.js";
import { h, number } from "./dom.js";
import { send } from "./server.js";

const COLOURS = ["--c0", "--c1", "--c2", "--c3", "--c4", "--c5", "--c6"];
const DASHES = [[], [2, 3], [8, 4], [8, 3, 2, 3]];
const HEIGHT = 210;
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name);

export class Board {
  constructor() {
    this.place = h("div", { class: "board" });
    this.plots = [];
    this.key = "";
    this.told = h("p", { class: "soft", role: "status" });
    this.whole = h("button", { type: "button", class: "small", onclick: () => this.zoom(null) }, "Whole time");
    this.whole.hidden = true;
    const moves = [["Earlier", -0.5, 1], ["Later", 0.5, 1], ["Closer", 0, 0.5], ["Farther", 0, 2]];
    this.element = h("section", { "aria-label": "Signals" },
      h("div", { class: "line tight" }, moves.map(([name, by, size]) => h("button",
        { type: "button", class: "small", onclick: () => this.move(by, size) }, name)),
      this.whole, this.told), this.place);
    new ResizeObserver(() => this.fit()).observe(this.place);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.again());
  }

  get width() {
    return Math.max(280, Math.floor(this.place.clientWidth || 900));
  }

  // Draw a frame; plots are kept where the panels are those that were there.
  draw(frame) {
    this.frame = frame;
    if (frame.window === null) this.all = frame;
    const key = JSON.stringify(frame.panels.map((p) => [p.title, p.unit, p.limits, p.windows,
      p.curves.map((c) => [c.label, c.run])]));
    const shown = frame.window ?? frame.span;
    if (key === this.key) {
      frame.panels.forEach((panel, i) => {
        this.plots[i].panel = panel;
        this.plots[i].setData(aligned(panel.curves), false);
        this.plots[i].batch(() => {
          this.plots[i].setScale("x", { min: shown[0], max: shown[1] });
        });
        describe(this.plots[i], panel);
      });
    } else {
      this.plots.forEach((plot) => plot.destroy());
      this.place.replaceChildren();
      this.plots = frame.panels.map((panel) => this.plot(panel, shown));
      this.key = key;
    }
    this.whole.hidden = frame.window === null;
    const points = Math.max(0, ...frame.panels.flatMap((p) => p.curves.map((c) => c.points)));
    const drawn = Math.max(0, ...frame.panels.flatMap((p) => p.curves.map((c) => c.x.length)));
    this.told.textContent = drawn < points
      ? `${points} recorded points, the least and the largest of each stretch are drawn; drag over a stretch to see every one`
      : `every one of ${points} recorded points`;
  }

  plot(panel, shown) {
    const figure = h("figure", {});
    this.place.append(figure);
    const runs = this.frame.panels.flatMap((p) => p.curves.map((c) => c.run));
    const compared = new Set(runs).size > 1;
    const series = panel.curves.map((curve, i) => {
      const before = panel.curves.slice(0, i).filter((c) => c.run === curve.run && !c.reference);
      return line(curve, i, compared, before.length);
    });
    const axis = { stroke: colour("--soft"), grid: { stroke: colour("--grid"), width: 1 },
      ticks: { stroke: colour("--grid"), width: 1 }, font: "12px system-ui, sans-serif" };
    const plot = new uPlot({
      title: panel.title,
      width: this.width,
      height: HEIGHT,
      cursor: { sync: { key: "time" }, drag: { x: true, y: false, setScale: false } },
      scales: { x: { time: false, min: shown[0], max: shown[1] } },
      axes: [
        { ...axis, values: (u, ticks) => ticks.map((t) => number(t, 9)) },
        { ...axis, size: 74, label: panel.unit === "1" ? "" : panel.unit, labelSize: 22,
          values: (u, ticks) => ticks.map((v) => String(Number(v.toPrecision(9)))) },
      ],
      series: [{ label: "time in s", value: (u, v) => (v === null ? "" : number(v, 9)) }, ...series],
      hooks: {
        draw: [(u) => marks(u)],
        setSelect: [(u) => {
          if (u.select.width < 4) return;
          const [from, to] = [u.posToVal(u.select.left, "x"),
            u.posToVal(u.select.left + u.select.width, "x")];
          u.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
          this.zoom([from, to]);
        }],
      },
    }, aligned(panel.curves), figure);
    plot.panel = panel;
    plot.root.querySelector("canvas").setAttribute("role", "img");
    figure.append(h("figcaption", { class: "unseen" }));
    plot.caption = figure.lastChild;
    describe(plot, panel);
    return plot;
  }

  // Move by a share of what is shown, and show `size` times as much: for the keyboard.
  move(by, size) {
    const [a, b] = this.frame.window ?? this.frame.span;
    const [first, last] = this.all.span;
    const half = Math.min((b - a) * size, last - first) / 2;
    const middle = Math.min(Math.max((a + b) / 2 + by * (b - a), first + half), last - half);
    this.zoom(half * 2 >= last - first ? null : [middle - half, middle + half]);
  }

  async zoom(window) {
    if (!window) return this.draw(this.all);
    const message = { do: "window", board: this.all.board, from: window[0], to: window[1],
      width: this.width };
    try {
      this.draw({ ...(await send(message).promise), span: this.all.span });
    } catch (error) {
      this.told.textContent = error.message;
    }
  }

  again() {
    this.key = "";
    if (this.frame) this.draw(this.frame);
  }

  fit() {
    this.plots.forEach((plot) => plot.setSize({ width: this.width, height: HEIGHT }));
  }
}

function aligned(curves) {
  if (!curves.length) return [[]];
  if (curves.every((c) => c.x === curves[0].x || same(c.x, curves[0].x))) {
    return [curves[0].x, ...curves.map((c) => c.y)];
  }
  const modes = curves.map(() => [1, 1]);
  return uPlot.join(curves.map((c) => [c.x, c.y]), modes);
}

const same = (a, b) => a.byteOffset === b.byteOffset && a.length === b.length;

function line(curve, i, compared, within) {
  const place = compared ? curve.run : i;
  return {
    label: curve.label,
    stroke: curve.reference ? colour("--reference") : colour(COLOURS[place % COLOURS.length]),
    width: 1.5,
    dash: curve.reference ? [6, 4] : compared ? DASHES[within % DASHES.length] : [],
    spanGaps: true,
    points: { show: (u, s, from, to) => to - from < u.bbox.width / 12 },
    value: (u, v) => (v === null || v === undefined ? "" : number(v)),
  };
}

// Windows of metrics as shades, limits of expectations as lines.
function marks(u) {
  const { ctx, bbox } = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.fillStyle = colour("--shade");
  for (const [from, to] of u.panel.windows) {
    const left = u.valToPos(from, "x", true);
    ctx.fillRect(left, bbox.top, u.valToPos(to, "x", true) - left, bbox.height);
  }
  ctx.strokeStyle = ctx.fillStyle = colour("--bad");
  ctx.font = `${11 * devicePixelRatio}px system-ui, sans-serif`;
  ctx.textAlign = "right";
  ctx.setLineDash([4, 4]);
  const named = new Set();
  for (const [value, text] of u.panel.limits) {
    const y = u.valToPos(value, "y", true);
    if (y < bbox.top || y > bbox.top + bbox.height) continue;
    ctx.beginPath();
    ctx.moveTo(bbox.left, y);
    ctx.lineTo(bbox.left + bbox.width, y);
    ctx.stroke();
    if (!named.has(text)) ctx.fillText(text, bbox.left + bbox.width - 4, y - 4);
    named.add(text);
  }
  ctx.restore();
}

// What a picture says to who cannot see it: the range of every curve.
function describe(plot, panel) {
  const ranges = panel.curves.map((c) => {
    let [low, high] = [Infinity, -Infinity];
    for (const v of c.y) {
      if (v < low) low = v;
      if (v > high) high = v;
    }
    return `${c.label} from ${number(low)} to ${number(high)}`;
  });
  const unit = panel.unit === "1" ? "" : ` ${panel.unit}`;
  const text = `${panel.title}${unit && `, in${unit}`}: ${ranges.join("; ")}`;
  plot.caption.textContent = text;
  plot.root.querySelector("canvas").setAttribute("aria-label", text);
}
