// Which view is shown: the address after # says it.

import { compare } from "./compare.js";
import { alertOf, h, say } from "./dom.js";
import { project } from "./project.js";
import { scenario } from "./scenario.js";
import { ask, changed, watch } from "./server.js";

const VIEWS = { "": project, scenario, compare };
const main = document.getElementById("main");
let view = null;
let shows = 0; // of which only the last counts
let missed = false; // files changed while a view was being made

async function show(again = false) {
  const [, kind = "", name = ""] = location.hash.match(/^#\/(\w*)\/?(.*)$/) ?? [];
  const mine = ++shows;
  view?.leave?.();
  view = null;
  main.setAttribute("aria-busy", "true");
  if (!again) {
    say("");
    main.replaceChildren(h("p", { class: "soft" }, "One moment …"));
  }
  let made;
  try {
    made = await (VIEWS[kind] ?? project)(decodeURIComponent(name));
  } catch (error) {
    const title = decodeURIComponent(name) || "feeddrive";
    made = { title, parts: [h("h1", {}, title), alertOf(error.message),
      h("p", {}, h("a", { href: "#/" }, "All scenarios"))] };
  }
  if (mine !== shows) return made.leave?.();
  view = made;
  main.replaceChildren(...view.parts);
  main.setAttribute("aria-busy", "false");
  document.title = `${view.title} · feeddrive`;
  view.entered?.();
  if (missed) look();
}

const details = () => [...main.querySelectorAll("details")];
const named = (one) => one.querySelector("summary").textContent.replace(/\d+/g, "");

// Read again what is shown, and stay where the user was.
async function refresh() {
  const place = scrollY;
  const { id, ariaLabel, textContent, tagName } = document.activeElement ?? {};
  const opened = new Set(details().filter((d) => d.open).map(named));
  await show(true);
  for (const one of details()) if (opened.has(named(one))) one.open = true;
  scrollTo(0, place);
  const same = [...main.querySelectorAll("button, input, select, textarea, summary")].find((e) =>
    id ? e.id === id : ariaLabel ? e.ariaLabel === ariaLabel
      : e.tagName === tagName && e.textContent === textContent);
  same?.focus({ preventScroll: true });
}

// Files changed: what is shown is made again if it would now look otherwise.
async function look() {
  missed = view === null;
  const before = view;
  if (before && (!before.changed || await before.changed()) && view === before) refresh();
}

addEventListener("hashchange", async () => {
  await show();
  scrollTo(0, 0);
  main.focus({ preventScroll: true });
});
addEventListener("refresh", refresh);
changed(look);
watch();
show();
ask("project").then(({ folder }) => {
  document.getElementById("folder").textContent = folder;
}, () => {});
