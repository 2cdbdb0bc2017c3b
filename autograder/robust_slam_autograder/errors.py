"""What can go wrong, told apart by whose fault it is."""


class AutograderError(Exception):
    """Base of every error that this package raises on purpose."""


class WrongUse(AutograderError):
    """The command or the instructor's files are wrong: nothing was graded (exit status 2)."""


class Refused(AutograderError):
    """A submission cannot be read as a notebook: score 0, with this one sentence as the reason."""


class GraderFailure(AutograderError):
    """The grader itself failed, or cannot write (exit status 1); the student is not to blame."""
