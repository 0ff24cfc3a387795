/* Draws of every curve what the screen can show of the stretch in view: all points
 * where they fit, else the least and the greatest of each stretch.  The curves lie in
 * the page as embedded.py writes them. */
"use strict";
(async () => {
  const BUCKETS = 1500, MARKED = 250, TINY = 1e-300;
  const plot = document.getElementById("signals");
  const told = document.getElementById("drawn");
  const { curves: stored, coarse } = JSON.parse(
    document.getElementById("recorded").textContent);
  const number = (n) => n.toLocaleString("en-US");

  async function decoded(text, n) {
    const packed = await fetch(`data:application/octet-stream;base64,${text}`);
    const inflate = new DecompressionStream("deflate");
    const stream = (await packed.blob()).stream().pipeThrough(inflate);
    const planes = new Uint8Array(await new Response(stream).arrayBuffer());
    const raw = new Uint8Array(8 * n);
    for (let byte = 0; byte < 8; byte++)
      for (let i = 0, last = 0; i < n; i++)
        raw[8 * i + byte] = last ^= planes[byte * n + i];
    return new Float64Array(raw.buffer);
  }

  async function read(curve) {
    const y = await decoded(curve.y, curve.n);
    const x = curve.x
      ? await decoded(curve.x, curve.n)
      : Float64Array.from(y, (_, i) => curve.first + i * curve.step);
    return { ...curve, x, y };
  }

  /* Return the first index whose time is not before t. */
  function place(x, t) {
    let low = 0, high = x.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (x[middle] < t) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /* Return the indices drawn of [from, to], one point beyond each side, and how many
   * points there are. */
  function thinned(curve, from, to) {
    const first = Math.max(0, place(curve.x, from) - 1);
    const last = Math.min(curve.n - 1, place(curve.x, to));
    const count = last - first + 1;
    if (count <= 2 * BUCKETS)
      return { count, kept: Array.from({ length: count }, (_, i) => first + i) };
    const kept = new Set([first]);
    for (let b = 0; b < BUCKETS; b++) {
      const start = first + Math.floor((b * count) / BUCKETS);
      const end = first + Math.floor(((b + 1) * count) / BUCKETS);
      let low = start, high = start;
      for (let i = start + 1; i < end; i++) {
        if (curve.y[i] < curve.y[low]) low = i;
        if (curve.y[i] > curve.y[high]) high = i;
      }
      kept.add(Math.min(low, high)).add(Math.max(low, high));
    }
    return { count, kept: [...kept.add(last)] };
  }

  /* Plotly fails at axes that would span denormal numbers. */
  const plain = (value) => (Math.abs(value) < TINY ? 0 : value);

  /* Draw what `axis` shows; all time axes show the same. */
  function draw(curves, axis) {
    const { autorange, range } = plot.layout[axis];
    const [from, to] = autorange === false ? range : [-Infinity, Infinity];
    const drawn = curves.map((curve) => thinned(curve, from, to));
    const taken = (key) => (c, i) => drawn[i].kept.map((k) => plain(c[key][k]));
    const few = (d) => (d.count <= MARKED ? "lines+markers" : "lines");
    const axes = Object.keys(plot.layout).filter((key) => /^xaxis\d*$/.test(key));
    const view = axes.flatMap((key) =>
      autorange === false
        ? [[`${key}.range`, [from, to]], [`${key}.autorange`, false]]
        : [[`${key}.autorange`, true]]);
    Plotly.update(
      plot,
      { x: curves.map(taken("x")), y: curves.map(taken("y")), mode: drawn.map(few) },
      Object.fromEntries(view),
      curves.map((curve) => curve.trace),
    );
    tell(drawn);
  }

  /* Say how much of the curves is drawn. */
  function tell(drawn) {
    const most = Math.max(...drawn.map((d) => d.count));
    told.textContent =
      (most <= 2 * BUCKETS
        ? `Every point ${coarse && "of the page "}in view is drawn, at most ` +
          `${number(most)} of a curve.`
        : `Drawn of a curve: the least and the greatest of each of ${number(BUCKETS)} ` +
          `stretches of up to ${number(most)} points in view; zoom in to see every one.`) +
      coarse;
  }

  if (!stored.length) return;
  if (!("DecompressionStream" in window)) {
    told.textContent += " This browser cannot show more when zooming.";
    return;
  }
  const curves = await Promise.all(stored.map(read));
  let shown = "";
  function follow(change) {
    const key = Object.keys(change).find((k) => /^xaxis\d*\.(auto)?range/.test(k));
    if (!key) return;
    const axis = key.split(".")[0], { autorange, range } = plot.layout[axis];
    const view = autorange === false ? JSON.stringify(range) : "whole";
    if (view === shown) return; /* drawing tells of the same view again */
    shown = view;
    draw(curves, axis);
  }
  plot.on("plotly_relayout", follow);
  shown = "whole"; /* is drawn already: as many stretches by figure.py */
  tell(curves.map((curve) => ({ count: curve.n })));
})();
