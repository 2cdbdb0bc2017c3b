"""The rules of a style sheet that a site can need.

A rule stays where each class of one of its selectors is a word of a page or of a script; the rest
is what the theme has for other sites.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

import tinycss2
from tinycss2 import ast

WORD = re.compile(r"-?[A-Za-z_][\w-]*")
COMPOSED = ("bs-",)
"""How classes begin that a script puts together."""
NESTED = {"media", "supports", "layer", "container"}


def words(texts: Iterable[str]) -> set[str]:
    """All words of the texts that may be names of classes."""
    return {word for text in texts for word in WORD.findall(text)}


def used_rules(style: str, known: set[str]) -> str:
    """Return the style without the rules for classes that are not known."""
    return _kept(tinycss2.parse_stylesheet(style, skip_comments=True), known)


def _kept(nodes: Iterable[ast.Node], known: set[str]) -> str:
    kept = []
    for node in nodes:
        if node.type == "qualified-rule":
            chosen = [each for each in _selectors(node.prelude) if _can_match(each, known)]
            if chosen:
                kept.append(f"{','.join(chosen)}{{{tinycss2.serialize(node.content).strip()}}}")
        elif node.type == "at-rule" and node.lower_at_keyword in NESTED and node.content:
            inner = tinycss2.parse_blocks_contents(node.content, skip_comments=True)
            text = _kept(inner, known)
            if text:
                prelude = tinycss2.serialize(node.prelude).strip()
                kept.append(f"@{node.at_keyword} {prelude}{{{text}}}")
        elif node.type == "error":
            raise ValueError(f"a style sheet cannot be read: {node.message}")
        elif node.type != "whitespace":
            kept.append(node.serialize())
    return "\n".join(kept)


def _selectors(prelude: list[ast.Node]) -> list[str]:
    """The selectors of a rule; commas within brackets do not part them."""
    parts: list[list[ast.Node]] = [[]]
    for node in prelude:
        if node.type == "literal" and node.value == ",":
            parts.append([])
        else:
            parts[-1].append(node)
    return [tinycss2.serialize(part).strip() for part in parts]


def _can_match(selector: str, known: set[str]) -> bool:
    """Whether every class outside brackets is known; within brackets there are choices."""
    outside = re.sub(r"\([^()]*(?:\([^()]*\)[^()]*)*\)|\[[^\]]*\]", "", selector)
    classes = [name.replace("\\", "") for name in re.findall(r"\.((?:[\w-]|\\.)+)", outside)]
    return all(name in known or name.startswith(COMPOSED) for name in classes)
