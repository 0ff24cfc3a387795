// Runs the module that lies in this page and draws its rows. Nothing is fetched.
const told = JSON.parse(document.getElementById("told").textContent);
const at = (id) => document.getElementById(id);

async function inflated(id) {
  const packed = Uint8Array.from(atob(at(id).textContent), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream();
  return new Response(stream.pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
}

const { instance } = await WebAssembly.instantiate(await inflated("module"), {});
const { memory, play_values, play_run, play_rows, play_failure, play_part, play_at } =
  instance.exports;

// A run

function settings() {
  const chosen = Number(at("rate").value) * told.latencies.length;
  const set = [];
  told.sliders.forEach((slider, i) => {
    const times = Number(at(`slider-${i}`).value);
    if (times !== 1)
      for (const p of slider.parameters) set.push({ ...p, to: p.value * times });
  });
  told.switches.forEach((p, i) => {
    const to = Number(at(`switch-${i}`).checked);
    if (to !== p.value) set.push({ ...p, to, written: to ? "true" : "false" });
  });
  return { variant: chosen + Number(at("latency").value), set };
}

// Rows of a variant with values that are set, as one array per signal; or an error.
function run({ variant, set }) {
  const { values, rows, every } = told.variants[variant];
  values.forEach((list, i) => place(i, list.length).set(list));
  for (const { component, reference, to } of set)
    place(told.components[component], reference + 1)[reference] = to;
  if (!play_run(variant)) {
    const part = Object.keys(told.components)[play_part()];
    const why = play_failure() === 1 ? "a value is no longer finite" : "it cannot go on";
    return { error: `${part} at t = ${play_at().toPrecision(4)} s: ${why}` };
  }
  const width = told.columns.length;
  const all = new Float64Array(memory.buffer, play_rows(0), rows * width);
  const signals = {};
  told.columns.forEach(({ name, gain, offset }, c) => {
    const converts = gain !== 1 || offset !== 0;
    signals[name] = Float64Array.from({ length: rows }, (_, i) => {
      const value = all[i * width + c];
      return converts ? gain * value + offset : value;
    });
  });
  const time = Float64Array.from({ length: rows }, (_, i) => (i * every[0]) / every[1]);
  return { time, signals };
}

function place(part, length) {
  return new Float64Array(memory.buffer, play_values(part), length);
}

// What is measured: as the metrics of the scenario say.

function measured(panel, { time, signals }) {
  const of = signals[panel.of], scale = panel.scale;
  const [start, end] = panel.window ?? [-Infinity, Infinity];
  let y, x = time, foot;
  if (panel.kind === "error") {
    const against = signals[panel.against];
    y = of.map((v, i) => against[i] * scale - v * scale);
  } else if (panel.kind === "peak") {
    y = of.map((v) => v * scale);
  } else {
    const across = signals[panel.across];
    foot = Array.from(of, (v, i) => nearest(v * scale, across[i] * scale, panel));
    y = Float64Array.from(foot, (f) => f.error);
  }
  let peak = 0, square = 0, n = 0;
  y.forEach((v, i) => {
    if (time[i] < start || time[i] > end) return;
    peak = Math.max(peak, Math.abs(v));
    square += v * v;
    n += 1;
  });
  const figures = { [`${panel.name}.peak`]: peak };
  if (panel.kind !== "peak") figures[`${panel.name}.rms`] = Math.sqrt(square / n);
  return { x, y, foot, figures, inside: (t) => t >= start && t <= end };
}

// The point of a contour nearest to (x, y), and how far outside (x, y) lies.
function nearest(x, y, { shape, size }) {
  if (shape === "circle") {
    const r = Math.hypot(x, y);
    return { x: (size * x) / r, y: (size * y) / r, away: [x, y], error: r - size };
  }
  const reach = Math.abs(x) + Math.abs(y);
  const along = Math.min(size, Math.max(0, (size - Math.abs(x) + Math.abs(y)) / 2));
  const foot = { x: Math.sign(x) * (size - along), y: Math.sign(y) * along };
  return { ...foot, away: [x, y], error: reach - size };
}

// Pictures

const HEIGHT = 190, LEFT = 74, RIGHT = 12, TOP = 8, BOTTOM = 36;

function ticks(low, high, most) {
  const rough = (high - low) / most, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find((n) => n * power >= rough) * power;
  const found = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++)
    found.push(Number((i * step).toPrecision(12)));
  return found;
}

// The least and the largest of each stretch, so that no peak is lost.
function thinned(x, y, parts) {
  if (x.length <= 2 * parts) return Array.from(x, (v, i) => [v, y[i]]);
  const found = [];
  for (let p = 0; p < parts; p++) {
    const from = Math.floor((p * x.length) / parts);
    const to = Math.floor(((p + 1) * x.length) / parts);
    let least = from, most = from;
    for (let i = from; i < to; i++) {
      if (y[i] < y[least]) least = i;
      if (y[i] > y[most]) most = i;
    }
    for (const i of least < most ? [least, most] : [most, least]) found.push([x[i], y[i]]);
  }
  return found;
}

function drawn(figure, curves, { equal, xLabel, yLabel }) {
  const svg = figure.querySelector("svg"), width = figure.clientWidth || 700;
  const height = equal ? Math.min(width, 560) : HEIGHT;
  const points = curves.flatMap((c) => c.points);
  const ends = (k) => points.reduce(([a, b], p) => [Math.min(a, p[k]), Math.max(b, p[k])],
    [Infinity, -Infinity]);
  let [x0, x1] = ends(0), [y0, y1] = ends(1);
  const room = (y1 - y0 || Math.abs(y1) || 1) * 0.05;
  [y0, y1] = [y0 - room, y1 + room];
  const wide = width - LEFT - RIGHT, high = height - TOP - BOTTOM;
  if (equal) { // as long on paper in x as in y
    [x0, x1] = [x0 - room, x1 + room];
    const each = Math.max((x1 - x0) / wide, (y1 - y0) / high);
    const about = (a, b, n) => [(a + b - each * n) / 2, (a + b + each * n) / 2];
    [x0, x1] = about(x0, x1, wide);
    [y0, y1] = about(y0, y1, high);
  }
  const X = (x) => LEFT + ((x - x0) / (x1 - x0)) * wide;
  const Y = (y) => TOP + ((y1 - y) / (y1 - y0)) * high;
  const text = (x, y, anchor, value, more = "") =>
    `<text x="${x}" y="${y}" text-anchor="${anchor}" ${more}>${value}</text>`;
  const line = (x, y, u, v) => `<line class="grid" x1="${x}" y1="${y}" x2="${u}" y2="${v}"/>`;
  const parts = [];
  for (const x of ticks(x0, x1, wide / 90))
    parts.push(line(X(x), TOP, X(x), TOP + high), text(X(x), TOP + high + 15, "middle", x));
  for (const y of ticks(y0, y1, high / 32))
    parts.push(line(LEFT, Y(y), LEFT + wide, Y(y)), text(LEFT - 6, Y(y) + 4, "end", y));
  parts.push(text(LEFT + wide / 2, height - 5, "middle", xLabel));
  const middle = TOP + high / 2;
  parts.push(text(14, middle, "middle", yLabel, `transform="rotate(-90 14 ${middle})"`));
  for (const { points: of, kind } of curves) {
    const path = of.map(([x, y]) => `${X(x).toFixed(1)},${Y(y).toFixed(1)}`).join("L");
    parts.push(`<path class="${kind}" d="M${path}"/>`);
  }
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  svg.innerHTML = parts.join("");
}

function magnification(found, size) {
  const most = Math.max(...found.map((f) => f.figures[Object.keys(f.figures)[0]]));
  const wanted = (0.15 * size) / (most || size), power = 10 ** Math.floor(Math.log10(wanted));
  return Math.max(1, power * [5, 2, 1].find((n) => n * power <= wanted));
}

function show(panel, figure, now, before) {
  const found = before ? [before, now] : [now];
  const kinds = before ? ["before", "now"] : ["now"];
  if (panel.kind !== "contour") {
    const parts = Math.ceil(figure.clientWidth || 700);
    const curves = found.map((f, i) => ({ points: thinned(f.x, f.y, parts), kind: kinds[i] }));
    drawn(figure, curves, { xLabel: "time in s", yLabel: panel.unit });
    return;
  }
  const M = magnification(found, panel.size);
  const each = panel.unit === "um" ? 1000 : 1, unit = panel.unit === "um" ? "mm" : panel.unit;
  const path = (f, by) => f.foot.filter((_, i) => f.inside(f.x[i]) && i % 8 === 0).map((p) =>
    [(p.x + by * (p.away[0] - p.x)) / each, (p.y + by * (p.away[1] - p.y)) / each]);
  const curves = found.map((f, i) => ({ points: path(f, M), kind: kinds[i] }));
  curves.unshift({ points: path(now, 0), kind: "shape" });
  drawn(figure, curves, { equal: true, xLabel: `x in ${unit}`, yLabel: `y in ${unit}` });
  figure.querySelector("h2").textContent = `${panel.name}: error magnified ${M} times`;
}

// What is told in words

function digits(value) {
  return String(Number(value.toPrecision(4)));
}

function labels() {
  const { every } = told.variants[settings().variant];
  const samples = told.latencies[Number(at("latency").value)];
  const delay = `${samples} ${samples === 1 ? "sample" : "samples"}, ` +
    `${digits((samples * 1e6 * every[0]) / every[1])} us`;
  said("rate", told.rates[Number(at("rate").value)]);
  said("latency", delay);
  told.sliders.forEach(({ parameters: [first] }, i) => {
    const times = Number(at(`slider-${i}`).value);
    said(`slider-${i}`, `${digits(first.value * times)} ${first.unit} (× ${digits(times)})`);
  });
}

function said(id, text) {
  at(`${id}-is`).textContent = text;
  at(id).setAttribute("aria-valuetext", text);
}

function command({ variant, set }) {
  const sets = told.variants[variant].sets.map((s) => (s.includes(" ") ? `"${s}"` : s));
  const written = set.map((p) => `${p.name}=${p.written ?? p.to}`);
  return [`feeddrive run ${told.scenario}`, ...[...sets, ...written].map((s) => `--set ${s}`)]
    .join(" ");
}

// All of it, whenever something is moved

const figures = told.panels.map((_, i) => at(`panel-${i}`));
let start = null, latest = null, asked = false;

function redraw() {
  latest?.forEach((found, i) =>
    show(told.panels[i], figures[i], found, latest === start ? null : start[i]));
}

function again() {
  asked = false;
  labels();
  const begun = performance.now(), wanted = settings(), result = run(wanted);
  at("command").textContent = command(wanted);
  at("error").textContent = result.error ?? "";
  if (result.error) return;
  const took = performance.now() - begun;
  latest = told.panels.map((panel) => measured(panel, result));
  start ??= latest;
  redraw();
  const rows = latest.flatMap((found, i) => Object.entries(found.figures).map(([name, value]) =>
    `<tr><th scope="row">${name}</th><td>${digits(value)} ${told.panels[i].unit}</td>` +
    `<td>${digits(start[i].figures[name])} ${told.panels[i].unit}</td></tr>`));
  at("figures").innerHTML = rows.join("");
  const instants = told.variants[wanted.variant].rows.toLocaleString("en");
  at("took").textContent = `${instants} instants in ${took.toFixed(0)} ms, here in this browser.`;
  document.dispatchEvent(new CustomEvent("played", { detail: { result, took } }));
}

function soon() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(again);
}

for (const input of document.querySelectorAll("input")) {
  input.addEventListener("input", soon);
  input.addEventListener("change", () => { // once it is let go
    const [name, value] = Object.entries(latest[0].figures)[0];
    at("status").textContent = `${name} ${digits(value)} ${told.panels[0].unit}`;
  });
}
at("back").addEventListener("click", () => { at("controls").reset(); again(); });
new ResizeObserver(redraw).observe(at("panels"));
again();
globalThis.played = { told, run, settings, ready: performance.now() };
