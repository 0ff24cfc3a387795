"""axe-core on the page that a browser shows."""

from pathlib import Path

from browsed import Page

AXE = Path(__file__).parents[1] / "data" / "axe" / "axe.min.js"
VIOLATIONS = """
const found = await axe.run();
return found.violations.map((v) => `${v.id}: ${v.nodes[0].html.slice(0, 200)}`);
"""


def violations(page: Page, scheme: str) -> list[str]:
    """Return what axe complains of, in a light or dark scheme of colours."""
    media = {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
    page.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", media)
    page.driver.execute_script(AXE.read_text(encoding="utf-8"))
    found: list[str] = page.js(VIOLATIONS)
    return found
