"""Markdown that somebody else wrote, as HTML that can do nothing but be read.

Formgrader shows a student's text in the instructor's own session: a script in it could give marks.
"""

from __future__ import annotations

from nbconvert.filters.markdown_mistune import IPythonRenderer, MarkdownWithMath
from nbconvert.preprocessors.sanitize import SanitizeHTML

_TAGS = (
    *("h1", "h2", "h3", "h4", "h5", "h6", "p", "br", "hr", "blockquote", "pre", "code"),
    *("ul", "ol", "li", "dl", "dt", "dd", "table", "thead", "tbody", "tr", "th", "td"),
    *("em", "strong", "b", "i", "u", "s", "del", "sup", "sub", "a"),
)
# No class and no id: formgrader finds its own buttons and fields by them.
_ATTRIBUTES = {"a": ["href", "title"], "th": ["align"], "td": ["align"]}


def as_html(source: str) -> str:
    """Turn Markdown with formulas into HTML; what is not plain text markup is shown as text.

    A filter for nbconvert's templates, in place of ``markdown2html``.
    """
    renderer = IPythonRenderer(escape=False, exclude_anchor_links=True)
    html = MarkdownWithMath(renderer=renderer).render(source)
    cleaner = SanitizeHTML(tags=list(_TAGS), attributes=_ATTRIBUTES)  # type: ignore[no-untyped-call]
    return str(cleaner.sanitize_html_tags(html))  # type: ignore[no-untyped-call]
