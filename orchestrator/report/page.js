/* What a page does by itself: it opens everything and fits plots to the paper when it
 * is printed, and puts legends into their panels where the screen is narrow. */
"use strict";
(() => {
  const NARROW = 700, PAPER = 680;
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

  const fitAll = () => plots().forEach((p) => fit(p, innerWidth < NARROW));
  fitAll();
  addEventListener("resize", fitAll);
  addEventListener("beforeprint", () => {
    document.querySelectorAll("details").forEach((d) => { d.open = true; });
    plots().forEach((p) => Plotly.relayout(p, { width: PAPER, autosize: false }));
  });
  addEventListener("afterprint", () =>
    plots().forEach((p) => Plotly.relayout(p, { width: null, autosize: true })));
})();
