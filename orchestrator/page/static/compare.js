// Kept runs over each other: what differs, their figures, their signals.

import { Board } from "./board.js";
import { alertOf, h, number, table, unitOf } from "./dom.js";
import { send } from "./server.js";

export async function compare(names) {
  const runs = names.split(",");
  const board = new Board();
  const body = h("div", {}, h("p", { class: "soft" }, "One moment …"));
  const draw = async (signals) => {
    try {
      const frame = await send({ do: "compare", runs, signals, width: board.width }).promise;
      body.replaceChildren(...told(frame, draw));
      board.draw(frame);
    } catch (error) {
      body.replaceChildren(alertOf(error.message));
    }
  };
  return {
    title: "Comparison",
    parts: [h("h1", {}, runs.length > 1 ? "Runs compared" : runs[0]),
      h("p", { class: "soft" }, h("a", { href: "#/" }, "All scenarios and runs")),
      body, h("h2", {}, "Signals"), board.element],
    entered: () => draw([]),
    changed: () => false,
  };
}

function told(frame, draw) {
  const parts = [];
  if (frame.runs.length > 1) {
    parts.push(frame.differences.length
      ? table("What differs", ["part", "key", ...frame.runs],
        frame.differences.map((d) => [d.part, d.key, ...d.values]))
      : h("p", {}, "The locks are equal: same scenario, FMUs and versions."));
  }
  if (frame.figures.length) {
    const two = frame.runs.length === 2;
    parts.push(table("Figures", ["figure", ...frame.runs, ...(two ? ["change"] : [])],
      frame.figures.map((f) => [f.name,
        ...f.values.map((v, i) => (f.units[i] ? `${number(v)} ${unitOf(f.units[i])}` : "")),
        ...(two ? [change(f)] : [])])));
  }
  if (frame.left.length) {
    const chosen = h("select", { id: "left" }, frame.left.map((name) => h("option", { value: name }, name)));
    parts.push(h("div", { class: "line" }, h("label", { for: "left" }, `${frame.left.length} more signals: `), chosen,
      h("button", { type: "button", onclick: () => draw([chosen.value]) }, "Draw this one"),
      h("button", { type: "button", onclick: () => draw([]) }, "Draw the first")));
  }
  return parts;
}

function change({ values: [a, b], units }) {
  if (a === null || b === null || units[0] !== units[1] || a === 0) return "";
  const percent = 100 * (b / a - 1);
  return Math.abs(percent) > 1000 ? "" : `${percent >= 0 ? "+" : ""}${number(percent, 3)} %`;
}
