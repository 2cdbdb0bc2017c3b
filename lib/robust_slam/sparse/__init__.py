"""Sparse symmetric matrices with one square block for each pose and each joined pair.

``pattern`` knows where the numbers of the edges go, ``elimination`` in which order poses
are best eliminated, ``simplicial`` and ``multifrontal`` factorise. What depends on the
edges alone is found once per graph; each step then fills in the numbers.
"""
