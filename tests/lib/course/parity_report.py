"""Print how the solvers in the page compare with the library.

Run ``python -m tests.lib.course.parity_report``.
"""

from __future__ import annotations

from tests.lib.course.parity import report

if __name__ == "__main__":
    print("\n".join(report()))
