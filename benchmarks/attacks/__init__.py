"""The same attacks on this course's grader and on plain nbgrader, side by side.

    python -m benchmarks.attacks

prints two Markdown tables: what became of every submission of ``tests/autograder/hostile`` and
``tests/autograder/correct.py`` under ``autograder grade``, and under ``nbgrader autograde`` with
``nbgrader generate_feedback``. Both sides grade the same submissions of the same assignment,
with the same time for a cell, and are judged by the same bounds.

nbgrader runs in its default configuration but for the source folder's name and the time for a
cell. It puts the hidden tests back itself; the seed of their inputs is a secret of the job's
environment, as a token is. Each batch, a few submissions between two correct neighbours, is
graded in a container of its own (``container``). A batch that is harmed is graded again one
submission at a time, so that the harm has one author; one that stops goes on without its
culprit, as an instructor would do it.

It takes about half an hour on two idle processors; ``--sample 40`` takes a few minutes. What is
known is kept, so that the same command goes on where it was interrupted. bubblewrap and
util-linux's ``setpriv`` and ``prlimit`` are needed.

What is unfair to nbgrader:

* The suite was written to try this course's grader, which was fixed until nothing got
  through. Its zeros say that the suite has no more to say, not that there is nothing left.
* nbgrader claims no protection against unsafe code: its manual refers to kernels in Docker
  containers. Such a kernel is not tried here. It keeps student code from the course's files,
  and so from neighbours, gradebook and token; tests and student code still share one process.
* Its feedback shows hidden tests to everybody by design, as its users know. The number of
  submissions whose own code read them stands beside.
* It has no modules to withhold: an instructor would leave the library that holds the answers
  out of the kernel's environment. That is the kind "reading: the library's answer".
* A submission that cannot be read and holds right answers, such as a truncated or oversized
  file, is no inflation where it earns them; only copies of other people's files are.

What is in nbgrader's favour: the container has no network and one small disk, limits memory
and processes, ends what hangs, and hides everything but the course; the suite knows the other
grader's pipe and its result files, which attack nothing here; hidden inputs count as leaked
only where they are those of the right answers' run.
"""
