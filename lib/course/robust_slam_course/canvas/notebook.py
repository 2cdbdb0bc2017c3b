"""Whether a person runs a cell, and how a notebook's widgets are called."""

from IPython.core.getipython import get_ipython

MIME = "application/vnd.jupyter.widget-view+json"


def someone_is_there() -> bool:
    """Tell whether a person runs the cell, and not a program that saves the notebook.

    The request that runs a cell says whether it could answer a question (``allow_stdin`` in
    Jupyter's messages). An export or a book build could not: what it saves has no kernel
    later, so a widget would be dead there.
    """
    shell = get_ipython()
    kernel = getattr(shell, "kernel", None)
    if kernel is None:
        return False
    request = kernel.get_parent("shell") or {}
    return bool(request.get("content", {}).get("allow_stdin", False))
