// Parameters as fields and sliders; what is moved is set beside the scenario's file.

import { h, number } from "./dom.js";

const STEPS = 400; // positions of a slider
const FIRST = 4; // parameters of a component that are seen at once

const kept = new Map(); // what was moved of each scenario, while the page is open

export class Parameters {
  constructor({ name, components }, moved) {
    this.name = name;
    this.settings = {};
    this.rows = new Map();
    this.reset = h("button", { type: "button", onclick: () => this.back() }, "Back to the scenario");
    this.reset.disabled = true;
    this.search = h("input", { type: "search", id: "search", oninput: () => this.filter() });
    const groups = components.filter((c) => c.parameters.length).map((c) => this.group(c));
    this.element = h("div", { class: "parameters" },
      h("div", { class: "line" },
        h("label", { for: "search" }, "Find "), this.search, this.reset), groups);
    this.moved = () => {};
    for (const [key, value] of Object.entries(kept.get(name) ?? {})) {
      if (this.rows.has(key)) this.set(this.rows.get(key).p, value);
    }
    kept.set(name, this.settings);
    this.moved = moved;
  }

  forget() {
    kept.delete(this.name);
  }

  group(component) {
    const given = component.parameters.filter((p) => p.given);
    const open = component.parameters.slice(0, Math.max(given.length, FIRST));
    return h("details", { open: true, class: "group" },
      h("summary", {}, component.name),
      open.map((p) => this.row(p)),
      open.length === component.parameters.length ? null
        : h("details", {}, h("summary", {}, `${component.parameters.length - open.length} more`),
          component.parameters.filter((p) => !open.includes(p)).map((p) => this.row(p))));
  }

  row(p) {
    const [low, high] = p.slider;
    const id = `p-${p.name}`;
    const bounds = [p.min === null ? null : `at least ${number(p.min)}`,
      p.max === null ? null : `at most ${number(p.max)}`].filter((b) => b).join(", ");
    const field = h("input", { type: "number", step: "any", id, value: p.value,
      min: p.min, max: p.max, "aria-describedby": `${id}-told`,
      onchange: () => this.set(p, field.valueAsNumber) });
    const slider = h("input", { type: "range", min: low, max: high, step: (high - low) / STEPS || "any",
      value: p.value, "aria-label": `${p.name}, slider`, "data-parameter": p.name,
      oninput: () => this.set(p, slider.valueAsNumber) });
    slider.value = p.value;
    const told = h("span", { class: "soft", id: `${id}-told` }, [p.about, bounds].filter((t) => t).join("; "));
    const error = h("span", { class: "error", role: "alert" });
    const element = h("div", { class: "parameter" },
      h("label", { for: id }, p.name.slice(p.name.indexOf(".") + 1)), field,
      h("span", { class: "unit" }, p.unit), slider, told, error);
    this.rows.set(p.name, { p, field, slider, error, element });
    return element;
  }

  set(p, value) {
    const { field, slider, error, element } = this.rows.get(p.name);
    const why = Number.isNaN(value) ? "give a number"
      : p.min !== null && value < p.min ? `at least ${number(p.min)}`
      : p.max !== null && value > p.max ? `at most ${number(p.max)}` : "";
    error.textContent = why;
    field.setAttribute("aria-invalid", String(Boolean(why)));
    if (why) return;
    if (document.activeElement !== field) field.value = value;
    slider.value = value;
    if (value === p.value) delete this.settings[p.name];
    else this.settings[p.name] = value;
    element.classList.toggle("moved", p.name in this.settings);
    this.reset.disabled = Object.keys(this.settings).length === 0;
    this.moved();
  }

  back() {
    for (const { p, field, slider, error, element } of this.rows.values()) {
      field.value = slider.value = p.value;
      error.textContent = "";
      element.classList.remove("moved");
    }
    for (const name of Object.keys(this.settings)) delete this.settings[name];
    this.reset.disabled = true;
    this.moved();
  }

  // Show an error at the parameter that it names; tell whether there is one.
  complain(message) {
    for (const name of Object.keys(this.settings)) {
      const { error } = this.rows.get(name);
      error.textContent = message.includes(name) ? message : "";
      if (error.textContent) return true;
    }
    return false;
  }

  filter() {
    const words = this.search.value.toLowerCase();
    for (const { p, element } of this.rows.values()) {
      const hit = `${p.name} ${p.about}`.toLowerCase().includes(words);
      element.hidden = !hit;
      if (hit && words) element.closest("details").open = true;
    }
  }
}
