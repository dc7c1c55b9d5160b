"""Files of the page, and the HTML that loads them."""

import html
from collections.abc import Iterable
from importlib.resources import files
from importlib.resources.abc import Traversable

WEB = files("hairpipe.app.page") / "web"
VENDOR = ("dagre.min.js", "uPlot.iife.min.js")
LICENCES = ("dagre.LICENSE.txt", "uPlot.LICENSE.txt")
STYLES = ("uPlot.min.css", "style.css")
_NAMES = """core app panes popup graph_layout annotations graph_view add_node graph_edit clipboard keys frame_strip
    work log camera light channels shaders scene rays viewer picking texels painted_mesh paint play pictures tables
    icons wedge_view slices templates stage profile soft_range trial files fields shot_fields panel verdict
    timeline live main"""
SCRIPTS = tuple(f"{name}.js" for name in _NAMES.split())
"""In the order of loading: the last one starts the page."""
MARK = "<!-- scripts -->"


def asset(name: str) -> Traversable:
    """Find a file of the page by its name; KeyError for a missing one."""
    if name not in (*VENDOR, *LICENCES, *STYLES, *SCRIPTS):
        raise KeyError(name)
    return WEB / "vendor" / name if name in VENDOR or name[:5] in ("dagre", "uPlot") else WEB / name


def page_html(before: Iterable[str], *, live: bool) -> str:
    """Write the HTML of the page that loads its files from the folder `page`.

    before  addresses of data scripts that are loaded before the page begins
    """
    addresses = [*(f"page/{name}" for name in (*VENDOR, *SCRIPTS[:1])), *before, *(f"page/{n}" for n in SCRIPTS[1:])]
    scripts = "\n".join(f'<script src="{html.escape(address)}"></script>' for address in addresses)
    return template(live).replace(MARK, scripts)


def page_in_one(data: str, *, live: bool = False) -> str:
    """Write the HTML of the page as a single file.

    data  scripts that load all documents, escaped by `values.script`
    """
    page = template(live)
    for name in STYLES:
        link = f'<link rel="stylesheet" href="page/{name}">'
        page = page.replace(link, f"<style>{asset(name).read_text(encoding='utf-8')}</style>")
    texts = [asset(name).read_text(encoding="utf-8") for name in (*VENDOR, *SCRIPTS)]
    inlined = [text.replace("</script", "<\\/script") for text in texts]
    place = len(VENDOR) + 1
    parts = [*inlined[:place], data, *inlined[place:]]
    return page.replace(MARK, "\n".join(f"<script>{part}</script>" for part in parts))


def template(live: bool) -> str:
    page = (WEB / "index.html").read_text(encoding="utf-8")
    return page.replace('data-state="loading"', f'data-state="loading" data-live="{str(live).lower()}"')
