"""Sparse symmetric matrices with one square block for each pose and each joined pair.

``pattern`` knows where the numbers of the edges go, ``elimination`` in which order poses
are best eliminated, ``simplicial`` and ``multifrontal`` factorise. What depends on the
edges alone is found once per graph; each step then fills in the numbers.
"""

import numpy as np

# The C library of Linux gives every block above a limit back to the system at once, and the
# next array of that size begins with fresh pages, which costs as much as the arithmetic in it.
# The limit follows the largest block that was ever freed, so one is freed here, never touched.
np.empty(4_000_000)
