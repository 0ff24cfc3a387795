// What the theme leaves out for screen readers and keys: parts of the navigation and
// of code have names of their own, what scrolls can be reached, an empty corner of a
// table heads nothing.
function named(nav, name) {
  nav.removeAttribute("aria-labelledby");
  nav.removeAttribute("aria-expanded");
  nav.setAttribute("aria-label", name);
}

function mended() {
  document.querySelectorAll(".md-nav .md-nav:not([aria-label])").forEach((nav, i) =>
    named(nav, `${nav.querySelector(".md-nav__title")?.textContent.trim() ?? "pages"}, ${i + 1}`));
  document.querySelectorAll(".md-code__nav:not([aria-label])").forEach((nav) =>
    named(nav, `code ${nav.closest("[id]")?.id ?? ""}`));
  for (const box of document.querySelectorAll(".md-typeset__scrollwrap, .drawn, pre > code"))
    if (box.tabIndex !== 0) box.tabIndex = 0;
  for (const corner of document.querySelectorAll("th:empty:not([role])"))
    corner.setAttribute("role", "presentation");
}

new MutationObserver(mended).observe(document.documentElement, { childList: true, subtree: true });
mended();
