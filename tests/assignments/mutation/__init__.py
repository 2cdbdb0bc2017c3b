"""Mutates the reference solutions, one small change at a time, and asks whether a case notices.

A mutant takes the reference's place in its solution cell, all other cells keep the reference, and
the grader marks that submission on the cases of the mutated exercise. A mutant that keeps full
marks survives: a case is missing, or the change changes nothing. What changes nothing is judged
so, with its reason, in ``solutions/answers/<assignment>/equivalents.toml``.

Why a mutator of our own: mutmut, cosmic-ray and mutatest were looked at, and none fits. Each
mutates the modules of an importable package and takes the exit status of a test command for the
verdict. Here the code is text between two marks in a notebook's cells, its tests are the
notebook's other cells, which only the grader runs, and the verdict wanted is which cases were
lost. With a test command every mutant would be a file to write into a notebook and a fresh grader
to start, two seconds each in place of a tenth; mutmut 3 knows pytest alone, and neither mutatest
nor the others drop keyword arguments, swap sum for mean, or match judged equivalents by text. What
would be left of such a tool is the list of changes, which is one module here.
"""
