"""Where pages of the site have gone: old addresses lead there. For docs/make_site.py."""

from __future__ import annotations

from pathlib import Path

# Old page: new page, and where in it.
MOVED = {
    "acceptance": "eyes#what-an-ommatidium-accepts",
    "baked-light": "light#baked-light",
    "columns": "motion-detection#columns",
    "error-target": "sampling#rays-to-an-error",
    "explanation": "index",
    "eye-design": "eyes#designing",
    "eye-files": "eyes#files",
    "eye-measures": "looking-at-eyes#measuring",
    "how-to": "index",
    "light-validation": "validation#lit-worlds",
    "many-cameras": "performance#many-small-cameras-cube-maps",
    "moving": "motion-and-time#moving-things",
    "neighbours": "motion-detection#neighbours",
    "noise": "sampling#noise-from-frame-to-frame",
    "photoreceptors": "receptors#photoreceptors-in-time",
    "point-sets": "sampling#which-points",
    "processes": "performance#threads-and-processes",
    "projections": "looking-at-eyes#projections",
    "releasing": "install#making-a-release",
    "shared-rays": "sampling#shared-rays",
    "sky": "light#the-clear-sky",
    "spectra-in-files": "materials#in-scene-files",
    "stimuli": "scenes#stimuli",
    "time": "motion-and-time#frames-that-last",
    "written-files": "datasets#files-that-are-written",
}


def page_of(name: str) -> str:
    """The page that has what the page of this name had."""
    return MOVED.get(name, name).split("#")[0]


def address_of(name: str) -> str:
    """What a link to an old page says now."""
    page, _, anchor = MOVED[name].partition("#")
    return f"{page}.html" + (f"#{anchor}" if anchor else "")


def write_moved(site: Path) -> None:
    """A page at each old address that leads to the new one, also without scripts."""
    for name in MOVED:
        to = address_of(name)
        (site / f"{name}.html").write_text(
            '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            f"<title>Omma: {name} has moved</title>\n"
            f'<meta http-equiv="refresh" content="0; url={to}">\n'
            f'<link rel="canonical" href="{to}">\n</head>\n<body>\n'
            f'<p>This page is now <a href="{to}">{to}</a>.</p>\n</body>\n</html>\n',
            encoding="utf-8",
        )
