"""Finds commented-out code with few false alarms.

A comment line counts as code if it ends with ';', '{' or '}' and has code's punctuation. Examples
are allowed if they are indented by two or more columns below a line of prose in the same comment.
"""

import re

_CONTROL = re.compile(
    r"(?:\}\s*)?(?:if|for|while|switch|catch)\s*(?:constexpr\s*)?\(.*\)\s*\{$|"
    r"(?:\}\s*)?else\s*\{$|(?:do|try)\s*\{$|"
    r"(?:template\s*<.*>\s*)?(?:enum\s+class|struct|class|enum|namespace)\s+[\w:]*[^;.]*\{$|"
    r"[\w:<>&*,\s]+[\s&*][\w:]+\(.*\)\s*(?:const|noexcept|override|\s)*\{$")
_CLOSING = re.compile(r"\}[\s;,)]*$")
_STATEMENT = re.compile(
    # A call, with a chain of members. Words before the name make it prose, except for a type.
    r"(?:(?:const\s+)?[\w:<>]+[&*]?\s+)?[\w:]+(?:(?:\.|->|::)\w+|\[\w*\]|\([^()]*\))*\(.*\);$|"
    # An assignment, or a definition with a value.
    r"(?:(?:const|static|constexpr|auto|unsigned)\s+)*[\w:<>,&*.\[\]()-]+(?:\s+[&*]*\w+)?\s*"
    r"[-+*/|&^]?=\s*[^=].*;$|"
    r"(?:(?:const|static)\s+)*(?:auto|bool|char|int|double|float|std::[\w:<>, ]+)[&*]*\s+\w+"
    r"(?:\{.*\})?;$|"
    r"(?:\+\+|--)\w+;$|\w+(?:\+\+|--);$|"
    r"(?:break|continue|return);$|(?:return|throw)\s+(?:\S+|.*[(){}<>=+*/].*);$|"
    r"(?:using|typedef)\s+[\w:\s=<>,*&]+;$|delete\s+\w+;$|"
    r"(?:std::)?c(?:out|err)\s*<<.*;$")


def looks_like_code(text):
    text = text.strip()
    if not text or text[-1] not in ";{}":
        return False
    if text[-1] == "{":
        return _CONTROL.match(text) is not None
    if text[-1] == "}":
        return _CLOSING.match(text) is not None or re.search(r";\s*\}$", text) is not None
    return _STATEMENT.match(text) is not None or _CLOSING.match(text) is not None


def lines(source):
    """Numbers of the lines that are commented-out code."""
    prose_indent = None  # of the comment block's last line of prose
    previous = None
    for number, (code, comment) in enumerate(zip(source.code, source.comments), 1):
        if not comment or code.strip():
            previous = None
            continue
        if previous != number - 1:
            prose_indent = None
        previous = number
        body = re.sub(r"^\s*(?://[/!]?|/\*+|\*(?!\w))", "", comment)
        body = re.sub(r"\*/$", "", body)
        indent = len(body) - len(body.lstrip())
        if not looks_like_code(body):
            if body.strip() and (prose_indent is None or indent <= prose_indent):
                prose_indent = indent
        elif prose_indent is None or indent < prose_indent + 2:
            yield number
