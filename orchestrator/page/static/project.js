// The first view: scenarios of the project, kept runs, published scenarios.

import { alertOf, h, number, table, unitOf } from "./dom.js";
import { ask, tell } from "./server.js";

export const address = (name) => `#/scenario/${encodeURIComponent(name)}`;
const SHOWN = 3; // figures in the line of a run

export async function project() {
  const found = await ask("project");
  const own = found.scenarios.filter((s) => s.own);
  const published = Map.groupBy(found.scenarios.filter((s) => !s.own),
    (s) => s.name.split("/")[0]);
  return {
    title: "Project",
    parts: [
      h("h1", {}, "Scenarios and runs"),
      h("section", {},
        h("h2", {}, "Scenarios of this project"),
        own.length ? h("ul", { class: "list" }, own.map(entry))
          : h("p", { class: "soft" }, "None yet. Copy a published one below, or begin one."),
        beginning()),
      h("section", {},
        h("h2", {}, "Kept runs"),
        found.runs.length ? runs(found.runs)
          : h("p", { class: "soft" }, "None yet: a scenario's Run button keeps one.")),
      h("section", {},
        h("h2", {}, "Published scenarios"),
        [...published].map(([study, listed]) => h("details", {},
          h("summary", {}, `${study} (${listed.length})`),
          h("ul", { class: "list" }, listed.map(entry))))),
    ],
  };
}

// A scenario begins with one component; the rest is added in its own view.
function beginning() {
  const place = h("div", {});
  const field = (id, label, value, size) => [h("label", { for: id }, label),
    h("input", { id, value, size })];
  const fields = [field("name", "name ", "", "14"), field("component", "its first component ", "plant", "10"),
    field("model", "FMU or model ", "", "28"), field("step", "step ", "1/20000", "9"), field("until", "stop in s ", "1", "6")];
  const begin = async () => {
    const [name, component, fmu, step, stop] = fields.map(([, input]) => input.value);
    try {
      const made = await tell("begin", { name, component, fmu, step, stop });
      location.hash = address(made.name);
    } catch (error) {
      place.replaceChildren(alertOf(error.message));
    }
  };
  return h("details", {}, h("summary", {}, "Begin a scenario"),
    h("div", { class: "line" }, fields.flat(), h("button", { type: "button", onclick: begin }, "Begin")), place);
}

function entry(scenario) {
  return h("li", {},
    h("a", { href: address(scenario.name) }, scenario.name),
    scenario.title ? h("span", { class: "soft" }, ` ${scenario.title}`) : null,
    scenario.error ? alertOf(scenario.error) : null);
}

// Runs are ticked to be looked at, or compared: the first ticked is compared with.
function runs(found) {
  const ticked = [];
  const look = h("button", { type: "button", onclick: () => {
    location.hash = `#/compare/${encodeURIComponent(ticked.join(","))}`;
  } }, "Show the ticked run");
  look.disabled = true;
  const tick = (name, on) => {
    if (on) ticked.push(name);
    else ticked.splice(ticked.indexOf(name), 1);
    look.disabled = ticked.length === 0;
    look.textContent = ticked.length > 1 ? `Compare ${ticked.length} runs` : "Show the ticked run";
  };
  return h("div", {}, h("div", { class: "line" }, look), table("Kept runs, the newest first",
    ["tick", "run", "begun", "state", "changed", "figures", "report"],
    found.map((run) => [
      h("input", { type: "checkbox", "aria-label": `tick ${run.name}`,
        onchange: (event) => tick(run.name, event.target.checked) }),
      run.name,
      new Date(run.begun).toLocaleString(),
      run.why ? `${run.state}: ${run.why.split("\n")[0]}` : run.state,
      run.changed.join(", "),
      Object.entries(run.metrics).slice(0, SHOWN)
        .map(([name, m]) => `${name} ${number(m.value, 5)} ${unitOf(m.unit)}`).join(", "),
      run.report ? h("a", { href: `/report/runs/${encodeURI(run.name)}/report.html`, target: "_blank",
        "aria-label": `report of ${run.name}` }, "report") : "",
    ])));
}
