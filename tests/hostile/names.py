"""Names that a file can bring, and that a page, a figure or a terminal could take for more."""

from __future__ import annotations

SCRIPTS = (
    "<img src=x onerror=\"window.ran='name'\">",
    "</script><script>window.ran='name'</script>",
    "</title></style><svg onload=window.ran='name'>",
    "\"' onmouseover=window.ran='name' autofocus onfocus=window.ran='name' x='",
    "javascript:window.ran='name'",
    "<!--<script>",
    "]]>--><script>window.ran='name'</script>",
    "&lt;b&gt; &amp;amp; &#x3c;script&#x3e;",
    "\u2028window.ran='name'//",
)
"""Markup; each would set ``window.ran``, or hide what follows."""

MARKS = ("/*COMMANDS*/", "/*MESHCAT*/", "/*NAME*/", "/*POLICY*/", "*/window.ran='name'/*")
"""Marks of our own template."""

TERMINAL = (
    "\x1b[2J\x1b]0;title\x07",
    "\x9b31m",
    "over\rwritten\b\b",
    "[bold red]x[/] [link=http://example.org]y[/link] :smile:",
    "[/]",
    "\u202edesrever",
    "not\udcffUTF-8",
)
"""Sequences that terminals obey, and markup of rich."""

FIGURES = (r"$\foo$", r"\$ $x$", "$", "_hidden", "{}", "%s %d", "\\")
"""What matplotlib takes for mathematics, and Python for formats."""

HOSTILE = (*SCRIPTS, *MARKS, *TERMINAL, *FIGURES)
