"""Prints each finding with its place; ends with status 1 if there is one."""

import sys

from tools.prose.check import ROOT, findings

found = list(findings(ROOT))
print(*found, sep="\n", end="\n" if found else "")
print(f"{len(found)} remarks on the language." if found else "The language is in order.")
sys.exit(bool(found))
