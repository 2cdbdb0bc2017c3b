"""The untrusted process: runs the student's cells and answers calls of their functions.

Started by ``session`` inside a sandbox, as a script. Nothing here guards
anything: student code shares this process and may rewrite all of it. What it
can reach is the sandbox's business, what it says is checked on the other side.
"""

import ast
import builtins
import contextlib
import os
import sys
import types
from collections.abc import Sequence

READY = b"ready\n"


def limit(limits: dict[str, int]) -> None:
    """Set resource limits by their names in the resource module, soft and hard alike."""
    import resource  # a browser has none

    for name, value in limits.items():
        kind = getattr(resource, name, None)
        if kind is None:
            continue
        hard = resource.getrlimit(kind)[1]
        if hard != resource.RLIM_INFINITY:
            value = min(value, hard)
        # Only Linux has a wall and keeps every limit; macOS refuses some.
        with contextlib.suppress(*(() if sys.platform == "linux" else (ValueError, OSError))):
            resource.setrlimit(kind, (value, value))


def volunteer_for_the_memory_killer() -> None:
    """Have the kernel end this process, and no neighbour, when memory runs out."""
    with contextlib.suppress(OSError), open("/proc/self/oom_score_adj", "w") as file:
        file.write("1000")


def drop_to(uid: int | None) -> None:
    """Become an ordinary user for good."""
    if uid is not None:
        os.setgroups([])
        os.setresgid(uid, uid, uid)
        os.setresuid(uid, uid, uid)


def set_aside_pipes() -> tuple[int, int]:
    """Move the pipes away from 0 and 1, so that print and input cannot touch them."""
    read_fd, write_fd = os.dup(0), os.dup(1)
    os.write(write_fd, READY)
    null = os.open(os.devnull, os.O_RDWR)
    for descriptor in (0, 1, 2):
        os.dup2(null, descriptor)

    def leave_the_conversation() -> None:
        for descriptor in (read_fd, write_fd):
            os.dup2(null, descriptor)

    # A forked child that answered too would spoil the exercises that follow.
    os.register_at_fork(after_in_child=leave_the_conversation)
    return read_fd, write_fd


def main() -> None:
    """Read the settings from the command line, then serve the other side."""
    settings = ast.literal_eval(sys.argv[1])
    sys.path[:] = settings["path"]
    # By its file: until it is there, no package in a source folder is found.
    sys.path.insert(0, settings["grader"])
    from robust_slam_autograder.student import imports

    del sys.path[0]
    imports.Installed(**settings["installed"]).install()
    volunteer_for_the_memory_killer()
    limit(settings["limits"])
    serve(settings["withheld"], settings["used"], settings["packages"])


def serve(withheld: Sequence[str], used: Sequence[str], packages: Sequence[str]) -> None:
    """Answer calls on standard input and output until they close; arguments as in ``Launch``."""
    from robust_slam_autograder.protocol.channel import Channel, ChannelClosed
    from robust_slam_autograder.protocol.notebook import Notebook, do_nothing
    from robust_slam_autograder.student import imports

    sys.argv[:] = [""]
    read_fd, write_fd = set_aside_pipes()
    sys.meta_path.insert(0, imports.Withheld(withheld))
    builtins.exit = builtins.quit = sys.exit  # type: ignore[assignment]
    builtins.help = do_nothing  # type: ignore[assignment]
    # Notebooks know themselves as __main__.
    notebook = Notebook(types.ModuleType("__main__"), used)
    notebook.names["__builtins__"] = imports.student_builtins(packages, withheld)
    what = ("read", "run", "kinds", "reached", "value", "call")
    channel = Channel(
        read_fd,
        write_fd,
        named={name: getattr(notebook, name) for name in what},
        describe=notebook.describe,
        tells=BaseException,
    )
    try:
        channel.serve()
    except ChannelClosed:
        os._exit(0)


if __name__ == "__main__":
    main()
