"""Sizes and openings: files under 600 lines, headers that teach, tests that say their goal."""

import re

from .tree import Finding, is_cpp, is_header, is_shell

LINES_MAX = 600
COUNTED = (".h", ".cpp", ".py", ".capnp", ".cmake", ".ts", ".js", ".css", ".html")
_TEST = re.compile(r"\s*(?:TEST|TEST_F|TEST_P|TYPED_TEST|TYPED_TEST_P|RC_GTEST_\w+)\s*\(")


def check(tree):
    for path in tree.files:
        lines = tree.lines(path)
        count = len(lines) - (lines[-1] == "")
        if (path.endswith(COUNTED) or is_shell(tree, path)) and count > LINES_MAX:
            yield Finding(path, LINES_MAX + 1, f"{count} lines; files stay under {LINES_MAX}")
        if is_header(path):
            yield from _header(tree, path)
        if is_cpp(path) and path.endswith("_test.cpp"):
            yield from _tests(tree, path)


def _header(tree, path):
    source = tree.source(path)
    if not any(re.fullmatch(r"\s*#\s*pragma\s+once\s*", code) for code in source.code):
        yield Finding(path, 1, "no #pragma once")
    first = next((n for n, raw in enumerate(source.raw) if raw.strip()), 0)
    if len(source.comments[first].strip("/* \t")) == 0:
        yield Finding(path, 1, "a header opens with a comment that says its idea")


def _tests(tree, path):
    """A comment right before a test or first in its body, or the file's own comment with "Goal:"."""
    source = tree.source(path)
    if _opening_states_goal(source):
        return
    for number, code in enumerate(source.code):
        if not _TEST.match(code):
            continue
        if number > 0 and _is_comment(source, number - 1):
            continue
        if not _opens_with_comment(source, number):
            yield Finding(path, number + 1, "a test's first comment gives its goal and method")


def _opening_states_goal(source):
    for raw, code, comment in zip(source.raw, source.code, source.comments):
        if code.strip() or not raw.strip():
            return False
        if "goal:" in comment.lower():
            return True
    return False


def _is_comment(source, number):
    return bool(source.comments[number].strip("/* \t")) and not source.code[number].strip()


def _opens_with_comment(source, number):
    """Returns whether the body that starts at or after a line begins with a comment."""
    while number < len(source.code) and "{" not in source.code[number]:
        number += 1
    if number == len(source.code):
        return True
    if source.code[number].split("{", 1)[1].strip():
        return False
    while number < len(source.code):
        if source.comments[number].strip("/* \t"):
            return True
        number += 1
        if number < len(source.code) and source.code[number].strip():
            return False
    return False
