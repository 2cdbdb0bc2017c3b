"""The kinds of submission that a grader withstands, and of correct work that it must not hurt."""

from __future__ import annotations

_HOSTILE = {
    "patched comparisons": "numpy, math, builtins, equal objects, arrays, lists",
    "replaced": "shell, kernel, transformers, hooks, compile, tracing, threads, grader state",
    "metadata": "tags, points, grade ids, locked flags, cell types, schema versions, "
    "forged outputs, moved tests, deleted tests",
    "files": "numpy, the library, the standard library, sitecustomize, conftest, IPython, "
    "Jupyter, pickles, links, a giant file",
    "reading": "history, frames, own notebook, source folder, gradebook, arguments, exceptions, "
    "environment, proc, the library's answer",
    "others": "a neighbour's notebook, a link to a neighbour, the gradebook, "
    "a background process, the parent",
    "resources": "loops, sleeps, signals, locks, memory, forks, threads, disk, output, images, "
    "exit, segfault, input, recursion, descriptors, network",
    "broken": "json, empty, binary, nesting, types, nbformat 3, nbformat 99, bom, utf-16, crlf, "
    "nan, surrogates, 60 MB, cells, syntax, name, directory, fifo, device, two notebooks, "
    "dots in an id, unicode in an id",
    "values": "nan, inf, complex, strings, none, generators, modules, object arrays, "
    "masked arrays, shapes, mutated inputs, random, state, call count",
    "pipe": "forged, lengths, floods, arrays, pickles",
}
_CORRECT = (
    "prints, warnings, logging, plots, magics, helper classes, extra imports, unicode names, "
    "a scratch error, deleted tests, no kernelspec, a copied cell, crlf, bom"
)

KINDS = tuple(f"{group}: {kind}" for group, text in _HOSTILE.items() for kind in text.split(", "))
"""As ``group: kind``."""
CORRECT = tuple(f"correct: {kind}" for kind in _CORRECT.split(", "))
