"""Tries answers that solve nothing on every exercise: none may earn a hidden point.

A lazy answer returns the right value for every input of the visible checks, by heart. For any
other input it returns a constant, an argument, or a simple function of one argument. Where a
function returns several things, in a tuple or a dict, each of them may be lazy in its own way. A
case with hidden checks counts as earned when every function that its cell calls, in everything
that it returns, has a lazy answer that passes while all else is the reference's.

Modules: ``memory`` remembers calls, ``guesses`` lists the lazy answers and ``search`` tries them.
"""
