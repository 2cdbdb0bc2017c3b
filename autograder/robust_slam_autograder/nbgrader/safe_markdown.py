"""nbconvert's filters for what a student wrote: HTML that can only be read, at a bounded cost.

Formgrader shows a student's text in the instructor's own session: a script in it could give marks.
The parsers behind these filters take quadratic time on some texts. So a long cell is shown as
plain text, and the time for a notebook grows no faster than its size.
"""

import re
from html import escape

from nbconvert.filters.highlight import Highlight2HTML
from nbconvert.filters.markdown_mistune import IPythonRenderer, MarkdownWithMath
from nbconvert.preprocessors.sanitize import SanitizeHTML

LONGEST = 5_000
"""Characters of a cell that is formatted: at twice the length some take four times as long."""
_GAP = re.compile(r"\s{200}")
"""Pygments' Python lexer and mistune are slowest on blanks."""
_EMBEDDED = re.compile(r"\(data:[^)\s]*")
"""The address of a picture whose bytes are in the text itself."""

_TAGS = (
    *("h1", "h2", "h3", "h4", "h5", "h6", "p", "br", "hr", "blockquote", "pre", "code"),
    *("ul", "ol", "li", "dl", "dt", "dd", "table", "thead", "tbody", "tr", "th", "td"),
    *("em", "strong", "b", "i", "u", "s", "del", "sup", "sub", "a"),
)
# No class and no id: formgrader finds its own buttons and fields by them.
_ATTRIBUTES = {"a": ["href", "title"], "th": ["align"], "td": ["align"]}


class _Renderer(IPythonRenderer):
    """nbconvert's renderer without pictures, and without lexers that the text chooses."""

    def image(self, text: str, url: str, title: str | None = None) -> str:
        """Say that a picture is left out: neither attachments nor files are read here."""
        return f"(picture left out: {text or escape(url)})"

    def block_code(self, code: str, info: str | None = None) -> str:
        """Show a fenced block as it is."""
        return f"<pre><code>{escape(code)}</code></pre>\n"


def as_html(source: str) -> str:
    """Turn Markdown with formulas into HTML; what is not plain text markup is shown as text.

    A filter for nbconvert's templates, in place of ``markdown2html``.
    """
    source = _EMBEDDED.sub("(data:", source)
    if _is_costly(source):
        return f"<pre>{escape(source)}</pre>"
    renderer = _Renderer(escape=False, exclude_anchor_links=True)
    html = MarkdownWithMath(renderer=renderer).render(source)
    cleaner = SanitizeHTML(tags=list(_TAGS), attributes=_ATTRIBUTES)  # type: ignore[no-untyped-call]
    return str(cleaner.sanitize_html_tags(html))  # type: ignore[no-untyped-call]


def code_as_html(source: str, language: str | None = None, metadata: object = None) -> str:
    """Colour Python code.

    A filter for nbconvert's templates, in place of ``highlight_code``. The lexer is always
    Python's: the one for IPython takes cubic time on blank lines.
    """
    if _is_costly(source):
        return f'<div class="highlight"><pre>{escape(source)}</pre></div>'
    return str(Highlight2HTML(pygments_lexer="python3")(source))  # type: ignore[no-untyped-call]


def unchanged(html: str) -> str:
    """Leave HTML as it is.

    A filter in place of ``strip_files_prefix``, which takes quadratic time on ``[``: a
    submission's other files are not shown, so there is no address to rewrite.
    """
    return html


def _is_costly(source: str) -> bool:
    return len(source) > LONGEST or _GAP.search(source) is not None
