"""Sparse symmetric matrices with one square block for each pose and each joined pair.

``pattern`` maps the entries of the edges into the matrix, ``elimination`` orders the poses,
``simplicial`` and ``multifrontal`` factorise, and ``ldl`` chooses between QDLDL and SciPy.
Whatever depends on the edges alone is computed once per graph; each step then fills in the
numbers.
"""
