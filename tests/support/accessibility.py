"""Accessibility of a page that is open in the browser, by axe-core.  `npm install` in page-lint brings it."""

from places import ROOT

AXE = ROOT / "page-lint" / "node_modules" / "axe-core" / "axe.min.js"
RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]


def violations(page):
    """What breaks a rule of WCAG 2.2 AA or of good practice: a line each, with the element."""
    page.evaluate(AXE.read_text(encoding="utf-8"))
    page.evaluate("Promise.all(document.getAnimations().map((one) => one.finished))")
    found = page.evaluate("(tags) => axe.run({runOnly: tags})", RULES)
    assert len(found["passes"]) > 10
    return [
        f"{broken['id']}: {node['target']} {node['failureSummary']}"
        for broken in found["violations"]
        for node in broken["nodes"]
    ]
