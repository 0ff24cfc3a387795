// The wiring and what can be changed of it: connections, components, the file's text.
// Every change is one of the scenario's file; the page then reads the scenario again.

import { alertOf, h, say, table, unitOf } from "./dom.js";
import { ask, tell } from "./server.js";
import { replacing } from "./replace.js";

export class Compose {
  constructor(found, again) {
    this.found = found;
    this.again = again;
    this.picture = h("div", { class: "picture" });
    this.text = h("div", {});
    this.parts = [
      found.own ? this.tools() : this.copying(),
      h("h2", {}, "Wiring"), this.picture,
      h("h2", {}, "Connections"), this.connections(),
      h("h2", {}, "Components"), this.components(), this.recorded(), this.text,
      h("h2", {}, "Timetable"), this.schedule(),
    ];
    this.draw();
  }

  async draw() {
    if (this.found.error) {
      this.picture.replaceChildren(h("p", { class: "soft" }, "Drawn once everything fits together."));
      return;
    }
    await svg(this.picture, "wiring", this.found.name);
    if (this.found.own) this.draggable();
  }

  // Change the file; what is refused stands beside what was asked for.
  async edit(content, place) {
    place.replaceChildren();
    try {
      await tell("edit", { scenario: this.found.name, ...content });
      this.again();
    } catch (error) {
      place.replaceChildren(alertOf(error.message));
    }
  }

  tools() {
    const place = h("div", {});
    const undo = h("button", { type: "button", onclick: async () => {
      try {
        await tell("undo", { scenario: this.found.name });
        this.again();
      } catch (error) {
        place.replaceChildren(alertOf(error.message));
      }
    } }, "Undo the last change");
    undo.disabled = !this.found.undo;
    return h("div", {}, h("div", { class: "line" }, undo,
      h("button", { type: "button", onclick: () => this.write() }, "Edit the text")), place);
  }

  copying() {
    const place = h("div", {});
    const name = h("input", { id: "copy", value: this.found.name.split("/").pop(), size: "30" });
    const copy = async () => {
      try {
        const made = await tell("own", { scenario: this.found.name, name: name.value });
        location.hash = `#/scenario/${encodeURIComponent(made.name)}`;
      } catch (error) {
        place.replaceChildren(alertOf(error.message));
      }
    };
    return h("div", {}, h("div", { class: "line" },
      h("label", { for: "copy" }, "Copy into the project as "), name,
      h("button", { type: "button", onclick: copy }, "Copy to change it")), place);
  }

  connections() {
    const place = h("div", {});
    const rows = this.found.connections.map((c) => {
      const remove = h("button", { type: "button", class: "small",
        "aria-label": `disconnect ${c.sink}`,
        onclick: () => this.edit({ do: "disconnect", sink: c.sink }, place) }, "Disconnect");
      const units = c.error ? "" : c.unit === c.from_unit ? unitOf(c.unit)
        : `${unitOf(c.from_unit)} to ${unitOf(c.unit)}`;
      const age = c.error || c.oldest === undefined ? ""
        : c.youngest === c.oldest ? c.oldest : `${c.youngest} to ${c.oldest}`;
      return [c.source, c.sink, units, age,
        c.error ? h("span", { class: "error", role: "alert" }, c.error) : c.remark ?? "",
        this.found.own ? remove : ""];
    });
    const held = this.found.undriven.map((u) => h("li", {},
      `${u.input} = ${Number(u.value.toPrecision(6))} ${unitOf(u.unit)}`));
    return h("div", {},
      table("Every connection, its unit and its age when it is taken",
        ["from", "to", "unit", "age", "remark", "change"], rows),
      held.length ? h("details", {}, h("summary", {},
        `${held.length} inputs that nothing drives hold their start`), h("ul", {}, held)) : null,
      this.found.own ? this.connecting(place) : null, place);
  }

  connecting(place) {
    const ends = (kind) => this.found.components.flatMap((c) => c[kind].map((p) =>
      h("option", { value: `${c.name}.${p.name}` },
        `${c.name}.${p.name}${p.unit && p.unit !== "1" ? ` (${p.unit})` : ""}`)));
    this.from = h("select", { id: "from" }, ends("outputs"));
    this.to = h("select", { id: "to" }, ends("inputs"));
    const connect = h("button", { type: "button", onclick: () => this.edit(
      { do: "connect", source: this.from.value, sink: this.to.value }, place) }, "Connect");
    return h("div", { class: "line", id: "connecting" }, h("label", { for: "from" }, "Connect "), this.from,
      h("label", { for: "to" }, "to "), this.to, connect);
  }

  // A line drawn from one box to another chooses among the ports of the two.
  draggable() {
    let begun = null;
    const box = (target) => target.closest?.("[data-component]")?.dataset.component;
    this.picture.addEventListener("pointerdown", (event) => {
      begun = box(event.target) ?? null;
      if (begun) event.preventDefault();
    });
    this.picture.addEventListener("pointerup", (event) => {
      const ended = box(event.target);
      if (!begun || !ended || begun === ended) return;
      choose(this.from, begun);
      choose(this.to, ended, new Set(this.found.connections.map((c) => c.sink)));
      say(`from ${begun} to ${ended}: choose the ports, then Connect`);
      this.from.focus();
      this.from.scrollIntoView({ block: "center" });
    });
  }

  components() {
    const place = h("div", {});
    const rows = this.found.components.map((c) => [
      c.name,
      [h("span", {}, c.fmu), c.error ? h("p", { class: "error", role: "alert" }, c.error) : null]
        .filter((part) => part).reduce((all, part) => (all.append(part), all), h("div", {})),
      c.kind, this.time(c, "step", c.step, c.rate, place), this.time(c, "latency", String(c.latency), "", place),
      String(c.steps),
      this.found.own ? h("div", { class: "line tight" },
        h("button", { type: "button", class: "small", "aria-label": `replace ${c.name}`,
          onclick: () => this.replace(c, place) }, "Replace"),
        h("button", { type: "button", class: "small", "aria-label": `remove ${c.name}`,
          onclick: () => this.edit({ do: "remove", name: c.name }, place) }, "Remove")) : "",
    ]);
    return h("div", {},
      table("Components, each an FMU", ["name", "FMU", "kind", "step", "latency", "steps", "change"], rows),
      this.found.own ? this.adding(place) : null, place);
  }

  time(component, key, value, told, place) {
    if (!this.found.own) return told || value;
    const size = key === "latency" ? "3" : "10";
    const field = h("input", { value, size, placeholder: told, "aria-label": `${key} of ${component.name}`,
      onchange: () => this.edit({ do: "times", name: component.name, key,
        value: key === "latency" ? Number(field.value) : field.value }, place) });
    return h("div", {}, field, told ? h("div", { class: "soft" }, told) : null);
  }

  adding(place) {
    const name = h("input", { id: "new-name", size: "12" });
    const step = h("input", { id: "new-step", size: "9", placeholder: "1/20000" });
    const fmu = h("input", { id: "new-fmu", size: "34", list: "known" });
    const known = h("datalist", { id: "known" });
    ask("parts").then(({ models, fmus }) => known.append(
      ...[...fmus, ...models].map((value) => h("option", { value }))), () => {});
    const add = h("button", { type: "button", onclick: () => this.edit(
      { do: "add", name: name.value, fmu: fmu.value, step: step.value }, place) }, "Add");
    return h("div", { class: "line" }, h("label", { for: "new-name" }, "Add a component "), name,
      h("label", { for: "new-fmu" }, "FMU or model "), fmu, known,
      h("label", { for: "new-step" }, "step "), step, add);
  }

  replace(component, place) {
    place.replaceChildren(replacing(this.found, component, () => this.again()));
    place.querySelector("input, select")?.focus();
  }

  // What is recorded, of what can be: a checkbox each.
  recorded() {
    const place = h("div", {});
    const known = new Set(this.found.record);
    const names = this.found.components.flatMap((c) => [...c.outputs, ...c.inputs].map((p) => `${c.name}.${p.name}`));
    const all = [...new Set([...this.found.record, ...names])];
    if (!this.found.own) return h("p", { class: "soft" }, `Recorded: ${this.found.record.join(", ")}`);
    return h("details", {}, h("summary", {}, `${known.size} recorded signals`),
      h("div", { class: "line" }, all.map((name) => {
        const box = h("input", { type: "checkbox", checked: known.has(name),
          onchange: () => this.edit({ do: "record", signal: name, on: box.checked }, place) });
        return h("label", {}, box, ` ${name}`);
      })), place);
  }

  schedule() {
    const place = h("div", { class: "picture" });
    const shown = h("details", { ontoggle: () => {
      if (shown.open && !place.hasChildNodes()) svg(place, "timetable", this.found.name);
    } }, h("summary", {}, "Who steps when, what is held, how old it is"), place);
    return this.found.error ? h("p", { class: "soft" }, "Drawn once everything fits together.") : shown;
  }

  async write() {
    const { text } = await ask("text", { name: this.found.name });
    const area = h("textarea", { id: "text", rows: "24", spellcheck: "false", wrap: "off" }, text);
    const place = h("div", {});
    const save = async () => {
      try {
        await tell("write", { scenario: this.found.name, text: area.value, before: text });
        this.again();
      } catch (error) {
        place.replaceChildren(alertOf(error.message));
      }
    };
    this.text.replaceChildren(h("h2", {}, "Text"),
      h("label", { for: "text" }, `The file ${this.found.name}`), area, place,
      h("div", { class: "line" }, h("button", { type: "button", class: "main", onclick: save }, "Save"),
        h("button", { type: "button", onclick: () => this.text.replaceChildren() }, "Close")));
    area.focus();
  }
}

function choose(select, component, taken = new Set()) {
  const own = [...select.options].filter((o) => o.value.startsWith(`${component}.`));
  const free = own.find((o) => !taken.has(o.value)) ?? own[0];
  if (free) select.value = free.value;
}

async function svg(place, view, name) {
  try {
    const text = await ask(view, { name });
    const drawn = new DOMParser().parseFromString(text, "image/svg+xml").documentElement;
    place.replaceChildren(document.importNode(drawn, true));
    place.setAttribute("tabindex", "0");
    place.setAttribute("role", "region");
    place.setAttribute("aria-label", `${view} of ${name}`);
  } catch (error) {
    place.replaceChildren(alertOf(error.message));
  }
}
