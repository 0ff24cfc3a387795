// Elements are made from data here and nowhere else: texts become text nodes, so that
// what a file or an FMU says is shown and never executed.

export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name in element && typeof value === "boolean") element[name] = value;
    else if (value !== null && value !== undefined) element.setAttribute(name, value);
  }
  element.append(...children.flat().filter((c) => c !== null && c !== undefined));
  return element;
}

export function table(caption, head, rows) {
  return h("div", { class: "wide", tabindex: "0", role: "region", "aria-label": caption },
    h("table", {},
      h("caption", {}, caption),
      h("thead", {}, h("tr", {}, head.map((name) => h("th", { scope: "col" }, name)))),
      h("tbody", {}, rows.map((row) => h("tr", row.attributes ?? {},
        (row.cells ?? row).map((cell) => h("td", {}, cell)))))));
}

export function alertOf(text) {
  return h("p", { class: "error", role: "alert" }, text);
}

export function say(text) {
  document.getElementById("status").textContent = text;
}

export function number(value, digits = 6) {
  if (value === null || value === undefined) return "none";
  return String(Number(value.toPrecision(digits)));
}

export function unitOf(unit) {
  return unit === "1" ? "" : unit;
}
