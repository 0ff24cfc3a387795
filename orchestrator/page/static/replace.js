// My FMU in place of yours: drop or choose it, look at its ports and map, put it in.

import { alertOf, h, table, unitOf } from "./dom.js";
import { ask, tell } from "./server.js";

const LARGEST = 200e6; // bytes, as the server has it

export function replacing(found, component, done) {
  const place = h("div", {});
  const choice = h("select", { id: "choice", onchange: () => choice.value && look(choice.value) },
    h("option", { value: "" }, "an FMU of the project …"));
  ask("parts").then(({ fmus }) => choice.append(
    ...fmus.map((file) => h("option", { value: file }, file))), () => {});
  const file = h("input", { type: "file", accept: ".fmu", id: "file",
    onchange: () => file.files[0] && take(file.files[0]) });
  const drop = h("div", { class: "drop",
    ondragover: (event) => event.preventDefault(),
    ondrop: (event) => {
      event.preventDefault();
      take(event.dataTransfer.files[0]);
    } },
  h("label", { for: "file" }, `Drop an .fmu here in place of ${component.name}, or choose the file `), file,
  h("label", { for: "choice" }, "or "), choice);

  async function take(one) {
    try {
      if (one.size > LARGEST) throw new Error(`${one.name} has more than ${LARGEST / 1e6} MB`);
      show(await ask("upload", { name: one.name }, one));
    } catch (error) {
      place.replaceChildren(alertOf(error.message));
    }
  }

  async function look(name) {
    try {
      show(await ask("fmu", { file: name }));
    } catch (error) {
      place.replaceChildren(alertOf(error.message));
    }
  }

  async function show(fmu) {
    const map = h("textarea", { id: "map", rows: "8", spellcheck: "false", wrap: "off" });
    const told = h("div", {});
    const propose = async (given) => {
      told.replaceChildren(h("p", { class: "soft" }, "comparing names and answers …"));
      try {
        const answer = await tell("propose", { scenario: found.name, name: component.name,
          fmu: fmu.file, ...(given === undefined ? {} : { map: given }) });
        map.value = answer.map;
        left = answer.left;
        numbers = answer.numbers;
        told.replaceChildren(
          ...(answer.error ? [alertOf(answer.error)] : []),
          ...left.map((one) => h("p", { class: "warning" }, one.text)),
          ...(numbers.length ? [h("p", { class: "soft" }, `${numbers.map((one) => one.text).join("; ")}.`)] : []),
          ...(answer.error ? [] : [h("p", { class: "good" }, "It fits in its place.")]));
      } catch (error) {
        told.replaceChildren(alertOf(error.message));
      }
    };
    let left = [], numbers = [];
    const put = h("button", { type: "button", class: "main", onclick: async () => {
      try {
        await tell("edit", { scenario: found.name, do: "replace", name: component.name, fmu: fmu.file,
          map: map.value, left: left.map((one) => one.name), numbers });
        done();
      } catch (error) {
        told.replaceChildren(alertOf(error.message));
      }
    } }, "Put it in place");
    place.replaceChildren(
      h("p", {}, h("strong", {}, fmu.name), ` ${fmu.about}`, h("span", { class: "soft" },
        ` FMI ${fmu.fmi}, by ${fmu.tool}, ${fmu.file}`)),
      fmu.faults.length
        ? h("div", { class: "warning" }, h("p", {}, `${fmu.faults.length} findings of ${fmu.checked} checks of its file:`),
          h("ul", {}, fmu.faults.map((text) => h("li", {}, text))))
        : h("p", { class: "good" }, `${fmu.checked} checks of its file found nothing; nothing of it was run.`),
      h("details", { open: true }, h("summary", {}, `${fmu.ports.length} ports and parameters`),
        table(`Ports of ${fmu.name}`, ["name", "causality", "unit", "start", "description"],
          fmu.ports.map((p) => [p.name, p.causality, unitOf(p.unit), p.start ?? "", p.about]))),
      h("label", { for: "map" }, "Map: our name = theirs. Proposed lines are guesses: check every one, above all gains and signs."),
      map, told,
      h("div", { class: "line" }, put,
        h("button", { type: "button", onclick: () => propose(map.value) }, "Check this map"),
        h("button", { type: "button", onclick: () => propose(undefined) }, "Propose again")));
    await propose(undefined);
  }

  return h("section", { class: "replace", "aria-label": `replace ${component.name}` },
    h("h3", {}, `In place of ${component.name}`), drop, place);
}
