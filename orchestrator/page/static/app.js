// Which view is shown: the address after # says it.

import { alertOf, h, say } from "./dom.js";
import { ask, changed, watch } from "./server.js";
import { project } from "./project.js";
import { scenario } from "./scenario.js";

const main = document.getElementById("main");
let view = null;

async function show(again = false) {
  const [, kind = "", name = ""] = location.hash.match(/^#\/(\w*)\/?(.*)$/) ?? [];
  view?.leave?.();
  view = null;
  say("");
  main.setAttribute("aria-busy", "true");
  if (!again) main.replaceChildren(h("p", { class: "soft" }, "One moment …"));
  try {
    const views = { "": project, scenario };
    const make = views[kind] ?? project;
    view = await make(decodeURIComponent(name));
    main.replaceChildren(...view.parts);
    main.setAttribute("aria-busy", "false");
    document.title = `${view.title} · feeddrive`;
    view.entered?.();
  } catch (error) {
    main.replaceChildren(h("h1", {}, decodeURIComponent(name) || "feeddrive"),
      alertOf(error.message), h("p", {}, h("a", { href: "#/" }, "All scenarios")));
  }
  main.setAttribute("aria-busy", "false");
}

addEventListener("hashchange", () => show().then(() => {
  scrollTo(0, 0);
  main.focus({ preventScroll: true });
}));
addEventListener("refresh", () => {
  const place = scrollY;
  show(true).then(() => scrollTo(0, place));
});
changed(() => (view?.changed ? view.changed() : show()));
watch();
show();
ask("project").then(({ folder }) => {
  document.getElementById("folder").textContent = folder;
}, () => {});
