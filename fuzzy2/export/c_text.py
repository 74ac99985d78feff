"""Text of C: parentheses, names, and removal of unused lines."""

from __future__ import annotations

import re

from fuzzy2.errors import printable

WORD = r"[A-Za-z_]\w*"
RESERVED = frozenset(
    {
        *("auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else"),
        *("enum", "extern", "float", "for", "goto", "if", "inline", "int", "long", "register"),
        *("restrict", "return", "short", "signed", "sizeof", "static", "struct", "switch"),
        *("typedef", "union", "unsigned", "void", "volatile", "while", "NAN", "INFINITY"),
    }
)
"""Words of C that cannot be names of variables."""


def words_of(text: str) -> set[str]:
    """Return the names in a text, except names of members."""
    return set(re.findall(rf"(?<![\w.>]){WORD}", text))


def ends(line: str) -> bool:
    """Return whether control never passes this line."""
    return bool(re.match(r"\s*(return\b|continue;|break;)", line))


def bare(code: str) -> str:
    """Return an expression without the parentheses around it."""
    if not (code.startswith("(") and code.endswith(")")):
        return code
    depth = 0
    for i, letter in enumerate(code):
        depth += {"(": 1, ")": -1}.get(letter, 0)
        if depth == 0 and i + 1 < len(code):
            return code
    return code[1:-1]


def members(code: str) -> list[str] | None:
    """Return the members of a struct literal ``(type){a, b}``; None for any other text."""
    head = re.match(r"\(\w+\)\{", code)
    if head is None or not code.endswith("}"):
        return None
    parts, depth = [""], 0
    for letter in code[head.end() : -1]:
        depth += {"(": 1, "[": 1, "{": 1, ")": -1, "]": -1, "}": -1}.get(letter, 0)
        if depth < 0:
            return None
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return [part.strip() for part in parts]


def without_idle(lines: list[str], variables: set[str]) -> list[str]:
    """Return lines without assignments to variables that are never read."""
    while True:
        heard = "\n".join(re.sub(r"^\s*\w+ = ", "", line) for line in lines)
        known = words_of(heard)
        kept = []
        for line in lines:
            match = re.match(r"(\s*)(\w+) = (.*);$", line)
            if match and match[2] in variables and match[2] not in known:
                if re.search(r"\w\(", match[3]):
                    call = re.match(r"\w+(\(.*\))$", match[3])
                    one = call is not None and bare(call[1]) != call[1]
                    code = match[3] if one else f"({match[3]})"
                    kept.append(f"{match[1]}(void){code};")
                continue
            kept.append(line)
        if kept == lines:
            return lines
        lines = kept


def otherwise(lines: list[str], space: str) -> list[str]:
    """Return the ``else`` of a branch, as ``else if`` if it only contains another branch."""
    inner = f"{space}    "
    own = [
        line[len(inner) :] for line in lines if line.startswith(inner) and line[len(inner)] > " "
    ]
    one = own[0].startswith("if (") and own[-1] == "}" and all(x[0] == "}" for x in own[1:])
    if not one:
        return [f"{space}}} else {{", *lines]
    # The last line closes the inner branch, and the caller closes the outer one.
    flat = [line[4:] for line in lines[:-1]]
    return [f"{space}}} else {flat[0].strip()}", *flat[1:]]


def comment(text: str) -> str:
    """Return a text that is safe in a comment: no name in it can end the comment.

    That includes ends across lines that a backslash joins, and a backslash written as a trigraph.
    """
    shown = printable(text).replace("``", "").replace("??/", "? ?/")
    return re.sub(r"\\(?=\s*(\n|$))", "|", shown).replace("*/", "* /").replace("/*", "/ *")
