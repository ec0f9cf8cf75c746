"""Configuration of the documentation site, for Sphinx.

`scripts/docs` builds the site: `docs/make_site.py` puts the pages together in build/site-source,
with those that it makes (reference, species, all figures), and calls Sphinx with this file.
"""

import os
import re
import sys
from pathlib import Path

from docutils import nodes
from sphinx.addnodes import pending_xref

import omma

sys.path.insert(0, os.path.dirname(__file__))

from site_docstrings import docstring, places

project = "Omma"
author = "the authors of Omma"
copyright = "the authors of Omma, MIT licence"
version = release = omma.__version__

extensions = [
    "myst_nb",  # pages in Markdown, tutorials as notebooks
    "sphinx.ext.autodoc",  # the reference, from docstrings
    "sphinx.ext.napoleon",  # their sections: Args, Raises, Example
    "sphinx_design",  # cards, and scripts that fold out
    "sphinx_copybutton",  # of blocks of code
]
root_doc = "index"
highlight_language = "text"
smartquotes = False  # quotes of commands are to be copied as they are
suppress_warnings = ["misc.highlighting_failure"]

# No formulas in TeX: what draws them would have to be loaded from elsewhere.
myst_enable_extensions = ["colon_fence"]  # ::: for cards
myst_heading_anchors = 4
myst_links_external_new_tab = False
nb_ipywidgets_js = {}
nb_execution_mode = os.environ.get("OMMA_DOCS_NOTEBOOKS", "cache")
nb_execution_cache_path = os.environ.get("OMMA_DOCS_CACHE", "")
nb_execution_timeout = 900
nb_execution_raise_on_error = True
nb_merge_streams = True

autodoc_typehints = "signature"
# Types of the package's own that have a name are shown by it, not by what they stand for.
PACKAGE = Path(omma.__file__).parent
autodoc_type_aliases = {"ArrayLike": "ArrayLike"} | {
    name: name
    for path in PACKAGE.rglob("*.py")
    for name in re.findall(
        r"^([A-Z]\w+) = [^\d\"(]", path.read_text(encoding="utf-8"), re.MULTILINE
    )
}
autodoc_member_order = "bysource"
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88
add_module_names = False
napoleon_custom_sections = [("Warns", "returns_style")]
napoleon_use_param = True
napoleon_use_rtype = False
copybutton_exclude = ".linenos, .gp, .go"
copybutton_prompt_text = r">>> |\.\.\. "
copybutton_prompt_is_regexp = True

html_theme = "pydata_sphinx_theme"
html_title = f"Omma {release}"
html_static_path = [os.path.join(os.path.dirname(__file__), "site")]
html_css_files = ["omma.css"]
html_copy_source = False
html_show_sourcelink = False
# Pages with nothing below them need no list of it.
html_sidebars = {name: [] for name in ("index", "search")}
html_theme_options = {
    "logo": {"text": "Omma"},
    "header_links_before_dropdown": 10,
    "navbar_align": "left",
    "navbar_persistent": ["search-button"],
    "navbar_end": ["theme-switcher"],
    "show_prev_next": True,
    "show_toc_level": 2,
    "navigation_with_keys": False,
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
}

COMMANDS = re.compile(r"\s*(omma|python|pip|scripts/|\.venv/|cd|mkdir|OMMA_)")


def color_commands(app, doctree):
    """Indented blocks of the pages are commands, where they begin as one."""
    for block in doctree.findall(lambda node: node.tagname == "literal_block"):
        if block.get("language", "text") in ("text", "default") and COMMANDS.match(block.astext()):
            block["language"] = "bash"


def link_names(app, doctree):
    """Public names between backquotes lead to their entries in the reference."""
    for literal in list(doctree.findall(nodes.literal)):
        full = places().get(literal.astext()) if literal.astext().startswith("omma.") else None
        if full and not isinstance(literal.parent, (nodes.reference, pending_xref)):
            link = pending_xref(
                "", refdomain="py", reftype="obj", reftarget=full, refexplicit=True, refwarn=False
            )
            link += literal.deepcopy()
            literal.replace_self(link)


def plain_names(app, what, name, obj, options, signature, returned):
    """Signatures of the compiled part say where a type is known to users."""

    def shorten(text):
        text = (text or "").replace("omma._core.", "omma.")
        array = r"(?:numpy\.)?ndarray\[tuple\[.*?Any, \.\.\.\], (?:numpy\.)?dtype\[([\w.]+)\]\]"
        return re.sub(array, r"NDArray[\1]", text)

    return signature and shorten(signature), returned and shorten(returned)


def setup(app):
    app.connect("doctree-read", color_commands)
    app.connect("doctree-read", link_names)
    app.connect("autodoc-process-docstring", docstring, priority=400)
    app.connect("autodoc-process-signature", plain_names)
    return {"parallel_read_safe": True}
