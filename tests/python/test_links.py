"""Links between the pages of the repository: each leads to a file, and to a heading that is there.

Links to other sites are not fetched: `python tests/python/test_links.py` lists them.
"""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted(
    page.relative_to(ROOT).as_posix()
    for page in [
        *ROOT.glob("*.md"),
        *ROOT.glob("bench/*.md"),
        *ROOT.glob("docs/**/*.md"),
        *ROOT.glob("examples/**/*.md"),
    ]
)
LINK = re.compile(r"\]\(([^)\s]+)\)")


def prose(page):
    """A page's text without its blocks of code."""
    text = (ROOT / page).read_text(encoding="utf-8")
    text = re.sub(r"^(`{3,})[^\n]*\n.*?^\1", "", text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"^    .*$", "", text, flags=re.MULTILINE)
    return re.sub(r"`[^`\n]*`", lambda code: "x" * len(code[0]), text)


def anchors(page):
    """The places in a page to which links can lead, as code hosts name headings."""
    found, text = set(), (ROOT / page).read_text(encoding="utf-8")
    text = re.sub(r"^(`{3,})[^\n]*\n.*?^\1", "", text, flags=re.MULTILINE | re.DOTALL)
    for heading in re.findall(r"^#+ (.+)$", text, flags=re.MULTILINE):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).strip().lower()
        name = base = re.sub(r"[^\w\- ]", "", plain).replace(" ", "-")
        again = 0
        while name in found:
            again += 1
            name = f"{base}-{again}"
        found.add(name)
    return found


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_to_files_and_headings(page):
    wrong = []
    for link in LINK.findall(prose(page)):
        if re.match(r"[a-z]+:", link):
            continue
        path, _, anchor = link.partition("#")
        target = (ROOT / page).parent / path if path else ROOT / page
        if not target.exists():
            wrong.append(f"{link}: no such file")
        elif anchor and anchor not in anchors(target.resolve().relative_to(ROOT).as_posix()):
            wrong.append(f"{link}: no such heading")
    assert not wrong, f"{page}: " + "; ".join(wrong)


def elsewhere():
    """All links to other sites, with the pages that have them."""
    found = {}
    for page in PAGES:
        for link in LINK.findall(prose(page)):
            if re.match(r"https?:", link):
                found.setdefault(link, []).append(page)
    return found


def test_links_to_other_sites_are_secure():
    assert elsewhere()
    assert not [link for link in elsewhere() if link.startswith("http:")]


if __name__ == "__main__":
    for link, pages in sorted(elsewhere().items()):
        print(link, *pages)
