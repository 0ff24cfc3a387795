/* What a page does by itself: it opens everything and fits plots to the paper when it
 * is printed, and puts legends into their panels where the screen is narrow. */
"use strict";
(() => {
  const NARROW = 700, PAPER = { width: 680, height: 820 }; /* px, of A4 as of letter */
  const plots = () => [...document.querySelectorAll(".js-plotly-plot")];
  const legends = (plot) =>
    Object.keys(plot.layout).filter((key) => /^legend\d*$/.test(key));

  /* Put the legends inside or beside the panels. */
  function fit(plot, inside) {
    if (plot.fitted === inside) return;
    plot.fitted = inside;
    const entries = legends(plot).flatMap((key) => [
      [`${key}.x`, inside ? 1 : 1.01],
      [`${key}.xanchor`, inside ? "right" : "left"],
      [`${key}.font.size`, inside ? 10 : 12],
      [`${key}.bgcolor`, inside ? "rgba(128,128,128,0.12)" : "rgba(0,0,0,0)"],
    ]);
    if (!entries.length) return;
    const left = inside ? 56 : 80;
    Plotly.relayout(plot, { ...Object.fromEntries(entries), "margin.l": left });
  }

  /* Draw the plots of what is opened: those nobody looks at take no time. */
  function unfold(details) {
    const place = details.querySelector("div");
    const told = details.querySelector('script[type="application/json"]');
    if (!details.open || place.children.length) return;
    const { data, layout } = JSON.parse(told.textContent);
    Plotly.newPlot(place, data, layout, { displaylogo: false, responsive: true });
  }
  document.querySelectorAll("details.folded").forEach((d) =>
    d.addEventListener("toggle", () => unfold(d)));

  const fitAll = () => plots().forEach((p) => fit(p, innerWidth < NARROW));
  fitAll();
  addEventListener("resize", fitAll);
  addEventListener("beforeprint", () => {
    document.querySelectorAll("details").forEach((d) => { d.open = true; });
    document.querySelectorAll("details.folded").forEach(unfold);
    plots().forEach((p) => {
      p.tall = p.layout.height;
      const height = Math.min(p.tall || PAPER.height, PAPER.height); /* one page */
      Plotly.relayout(p, { width: PAPER.width, height, autosize: false });
    });
  });
  addEventListener("afterprint", () =>
    plots().forEach((p) =>
      Plotly.relayout(p, { width: null, height: p.tall, autosize: true })));
})();
