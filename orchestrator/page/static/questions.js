// Sweep, response and tune: the verbs of the command line, asked from here.

import { alertOf, h } from "./dom.js";
import { send } from "./server.js";

const LINES = 200; // of a log that are seen

export class Questions {
  constructor(found, figures) {
    this.found = found;
    const names = found.components.flatMap((c) => c.parameters.map((p) => p.name));
    const outputs = found.components.flatMap((c) => c.outputs.map((p) => `${c.name}.${p.name}`));
    const known = h("datalist", { id: "known-parameters" }, names.map((value) => h("option", { value })));
    const ends = h("datalist", { id: "known-outputs" }, outputs.map((value) => h("option", { value })));
    const results = h("datalist", { id: "known-figures" });
    this.log = h("pre", { role: "log", tabindex: "0", "aria-label": "log" });
    this.log.hidden = true;
    this.answer = h("div", {});
    this.abort = h("button", { type: "button", onclick: () => this.stop() }, "Abort");
    this.abort.hidden = true;
    this.element = h("div", {}, known, ends, results,
      this.form("Sweep", "its figures over values of a parameter",
        [["vary", "parameter ", "known-parameters"], ["values", "values ", null, "+-20%:9"]],
        ({ vary, values }) => ["sweep", { vary: `${vary}=${values}` }]),
      this.form("Response", "open loop, sensitivity and margins where a loop is broken",
        [["break", "broken at ", "known-outputs"]],
        (given) => ["response", given.break ? { break: given.break } : {}]),
      this.form("Tune", "parameters found that make a figure least",
        [["free", "free ", "known-parameters"], ["minimise", "least ", "known-figures"],
          ["bound", "with ", null, "", "say u.peak <= 5"], ["generations", "generations ", null, "10"]],
        ({ free, minimise, bound, generations }) => ["tune",
          { free, minimise, generations, ...(bound ? { "subject-to": bound } : {}) }]),
      h("div", { class: "line" }, this.abort), this.log, this.answer);
    this.element.addEventListener("focusin", () => results.replaceChildren(
      ...figures().map((f) => h("option", { value: f.name }))));
  }

  form(title, about, fields, asked) {
    const inputs = fields.map(([name, , list, value = "", placeholder = ""]) =>
      h("input", { id: `${title}-${name}`, list, value, placeholder, size: value ? "9" : "24" }));
    const go = h("button", { type: "button", "aria-label": `ask ${title}`, onclick: () => {
      const given = Object.fromEntries(fields.map(([name], i) => [name, inputs[i].value.trim()]));
      this.ask(...asked(given));
    } }, "Ask");
    return h("details", {}, h("summary", {}, `${title}: ${about}`),
      h("div", { class: "line" }, fields.map(([name, label], i) =>
        [h("label", { for: `${title}-${name}` }, label), inputs[i]]).flat(), go));
  }

  async ask(verb, options) {
    if (this.asked) return;
    this.log.replaceChildren();
    this.log.hidden = this.abort.hidden = false;
    this.answer.replaceChildren();
    const lines = [];
    this.asked = send({ do: "ask", verb, scenario: this.found.name, options }, ({ line }) => {
      lines.push(line);
      this.log.textContent = lines.slice(-LINES).join("\n");
      this.log.scrollTop = this.log.scrollHeight;
    });
    try {
      const { pages, kept, told } = await this.asked.promise;
      this.answer.replaceChildren(h("p", { class: "good", role: "status" },
        `${verb} is done${kept.length ? `, kept in ${kept[0]}` : `: ${told.scenario}`}.`),
      ...pages.flatMap((page) => [
        h("p", {}, h("a", { href: `/report/${encodeURI(page)}`, target: "_blank" }, page)),
        h("iframe", { src: `/report/${encodeURI(page)}`, title: `${verb}: ${page}`, sandbox: "allow-scripts" })]));
    } catch (error) {
      this.answer.replaceChildren(alertOf(error.message));
    }
    this.asked = null;
    this.abort.hidden = true;
    this.log.hidden = this.log.textContent === "";
  }

  stop() {
    if (this.asked) send({ do: "abort", run: this.asked.id });
  }
}
