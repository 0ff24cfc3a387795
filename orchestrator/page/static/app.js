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

// Read again what is shown, and stay where the user was.
async function refresh() {
  const place = scrollY;
  const { id, ariaLabel, textContent, tagName } = document.activeElement ?? {};
  await show(true);
  scrollTo(0, place);
  const same = [...main.querySelectorAll("button, input, select, textarea, summary")].find((e) =>
    id ? e.id === id : ariaLabel ? e.ariaLabel === ariaLabel
      : e.tagName === tagName && e.textContent === textContent);
  same?.focus({ preventScroll: true });
}

function look() {
  missed = view === null;
  if (view?.changed) view.changed();
  else if (view) refresh();
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
