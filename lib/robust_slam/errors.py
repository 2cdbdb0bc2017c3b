"""The errors of solvers: the problem has no unique solution, or none was found."""


class Underdetermined(ValueError):
    """The measurements with positive weight do not determine x."""


def singular(what: str) -> Underdetermined:
    """Return the error that ``what``, such as "the positions are", is singular, and the remedy."""
    return Underdetermined(
        f"{what} singular to working precision: some edges weigh almost nothing beside the "
        "others; give such edges weight 0 or trust more edges"
    )


class NotConverged(RuntimeError):
    """An iteration did not converge within its limit."""
