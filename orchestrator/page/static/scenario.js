// A scenario: what it is made of, its parameters, and its curves while they are moved.

import { Board } from "./board.js";
import { Compose } from "./compose.js";
import { alertOf, h, number, say, table, unitOf } from "./dom.js";
import { Parameters } from "./parameters.js";
import { Questions } from "./questions.js";
import { ask, send, tell } from "./server.js";

export async function scenario(name) {
  const found = await ask("scenario", { name });
  const view = new Scenario(found);
  return {
    title: found.name,
    parts: view.parts,
    entered: () => view.redraw(),
    leave: () => view.leave(),
    changed: () => view.changed(),
  };
}

class Scenario {
  constructor(found) {
    this.found = found;
    this.board = new Board();
    this.errors = h("div", {});
    this.figures = h("div", {});
    this.parameters = new Parameters(found, () => this.redraw());
    this.compose = new Compose(found, () => dispatchEvent(new Event("refresh")));
    this.questions = new Questions(found, () => this.shown?.figures ?? []);
    this.command = h("code", {});
    this.write = h("button", { type: "button", onclick: () => this.into() }, "Write into the scenario");
    this.write.hidden = !found.own;
    this.run = h("button", { type: "button", class: "main", onclick: () => this.keep() }, "Run and keep");
    this.pace = h("input", { id: "pace", size: "5", placeholder: "none", inputmode: "decimal" });
    this.abort = h("button", { type: "button", onclick: () => this.stop() }, "Abort");
    this.abort.hidden = true;
    this.run.disabled = Boolean(found.error);
    this.progress = h("progress", { max: "1", value: "0", "aria-label": "progress of the run" });
    this.progress.hidden = true;
    this.parts = [
      h("h1", {}, found.title || found.name),
      h("p", { class: "soft" }, h("a", { href: "#/" }, "All scenarios"), ` · ${found.name}`,
        found.own ? "" : " · published, cannot be changed here"),
      found.description ? h("p", { class: "about" }, found.description) : null,
      found.error ? alertOf(found.error) : null,
      ...found.warnings.map((text) => h("p", { class: "warning" }, text)),
      h("div", { class: "two" },
        h("div", {},
          h("div", { class: "line" }, this.run,
            h("label", { for: "pace" }, "held to times real time: "), this.pace, this.abort, this.progress),
          this.errors, this.figures, this.board.element),
        h("div", { class: "side" },
          h("h2", {}, "Parameters"), this.parameters.element, this.write,
          h("p", { class: "soft" }, "The same on the command line: ", this.command))),
      ...this.compose.parts,
      h("h2", {}, "Questions"), this.questions.element,
    ].filter((part) => part);
    this.asked = null;
    this.again = false;
  }

  // Make what was moved the scenario's own.
  async into() {
    try {
      await tell("edit", { scenario: this.found.name, do: "values", settings: this.parameters.settings });
      this.parameters.forget();
      dispatchEvent(new Event("refresh"));
    } catch (error) {
      this.fail(error);
    }
  }

  // Run with the positions of the sliders; while one runs only the last one waits.
  async redraw() {
    this.write.disabled = Object.keys(this.parameters.settings).length === 0;
    if (this.found.error) return;
    this.command.textContent = ["feeddrive run", this.found.name,
      ...Object.entries(this.parameters.settings).map(([k, v]) => `--set ${k}=${v}`)].join(" ");
    if (this.asked) {
      this.again = true;
      return;
    }
    const settings = this.parameters.settings;
    const message = { do: "try", scenario: this.found.name, settings, width: this.board.width };
    this.asked = send(message);
    try {
      const frame = await this.asked.promise;
      this.errors.replaceChildren();
      if (frame.later) this.figures.replaceChildren(h("p", { class: "soft" }, frame.later));
      else this.show(frame);
      document.dispatchEvent(new CustomEvent("drawn", { detail: { settings, frame } }));
    } catch (error) {
      this.fail(error);
      document.dispatchEvent(new CustomEvent("drawn", { detail: { settings, error } }));
    }
    this.asked = null;
    if (this.again) {
      this.again = false;
      this.redraw();
    }
  }

  show(frame) {
    this.shown = frame;
    this.board.draw(frame);
    this.figures.replaceChildren(figures(frame), ...notes(frame));
  }

  fail(error) {
    const told = this.parameters.complain(error.message);
    this.errors.replaceChildren(alertOf(told ? `${error.message}` : error.message));
  }

  async keep() {
    this.running = send({ do: "run", scenario: this.found.name,
      settings: this.parameters.settings, width: this.board.width,
      ...(this.pace.value ? { pace: Number(this.pace.value) } : {}) }, (frame) => this.live(frame));
    this.busy(true);
    say("running");
    try {
      const frame = await this.running.promise;
      this.errors.replaceChildren();
      this.show(frame);
      say(`run kept in ${frame.kept}`);
    } catch (error) {
      this.fail(error);
      say("the run ended early");
    }
    this.running = null;
    this.busy(false);
    document.dispatchEvent(new CustomEvent("ran"));
  }

  live(frame) {
    this.progress.value = frame.t / frame.stop;
    say(`running: ${number(frame.t, 4)} of ${number(frame.stop, 4)} s`);
    if (frame.panels.length) this.board.draw({ ...frame, span: [0, frame.stop] });
  }

  stop() {
    if (this.running) send({ do: "abort", run: this.running.id });
  }

  busy(now) {
    this.run.disabled = now;
    this.abort.hidden = this.progress.hidden = !now;
    this.progress.value = 0;
    if (now) this.abort.focus();
    else this.run.focus();
  }

  // Tell whether the scenario would now be shown otherwise; sliders stay where they are.
  async changed() {
    if (this.running) return false;
    try {
      const found = await ask("scenario", { name: this.found.name });
      return JSON.stringify(found) !== JSON.stringify(this.found);
    } catch {
      return true;
    }
  }

  leave() {
    this.stop();
    this.questions.stop();
  }
}

function figures(frame) {
  if (!frame.figures.length) return h("p", { class: "soft" }, "The scenario defines no metrics.");
  return table("Figures", ["figure", "value", "unit", "expected"], frame.figures.map((f) => ({
    attributes: { "data-figure": f.name, "data-value": f.value },
    cells: [
      f.name,
      f.value === null ? f.why : number(f.value),
      unitOf(f.unit),
      f.expected ? h("span", { class: f.met ? "good" : "bad" },
        `${f.met ? "✓ met: " : "✗ not met: "}${f.expected}`) : "",
    ],
  })));
}

function notes(frame) {
  const bad = [frame.diverged, ...frame.unlike].filter((text) => text);
  const told = [frame.paced, frame.ended, ...frame.warnings].filter((text) => text);
  return [...bad.map((text) => h("p", { class: "error" }, text)),
    ...told.map((text) => h("p", { class: "warning" }, text))];
}
