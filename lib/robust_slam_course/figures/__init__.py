"""Figures as parts of a page: its font, its colours, and a drawing of its own for phones.

`page_html` draws a matplotlib figure twice, as it is and for a narrow page, both as SVG that
stands in the page itself. The page's style sheet says what the colours are, in the light, in the
dark and on paper, and which of the two drawings there is room for.
"""

from robust_slam_course.figures.page import is_for_a_page, page_html

__all__ = ["is_for_a_page", "page_html"]
