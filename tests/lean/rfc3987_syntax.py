"""Stands before the package of this name, on the path of programs that tests start.

jsonschema, which nbformat imports, has it make forty parsers of addresses, and nothing here uses
one: more than a second in each process. Without them jsonschema goes on.
"""

raise ImportError(__doc__)
