"""Forbidden constructs, above all those that would make results differ by machine."""

import re

from . import commented_code
from .cmake import without_comments
from .tree import Finding, is_cmake, is_cpp, is_in

# Code whose numbers reach an archive.
RESULTS = ("common/math", "common/random", "worker")
# Files that define our own functions of these names, which call each other unqualified.
WRAPPED = re.compile(r"common/math/elementary\w*\.(?:h|cpp)")
# Code in which order reaches an archive.
ORDERED = ("worker", "common/plan", "service/core")

_TRANSCENDENTAL = (
    "sin|cos|tan|asin|acos|atan|atan2|sinh|cosh|tanh|asinh|acosh|atanh|exp|exp2|exp10|"
    "expm1|log|log2|log10|log1p|pow|cbrt|hypot|erf|erfc|tgamma|lgamma|gamma")
_STD_ONLY = r"sincos|beta|riemann_zeta|expint|legendre|cyl_\w+|sph_\w+|ellint_\w+|comp_ellint_\w+"
# A call with std::, with :: or unqualified. other::sin, x.sin and x->sin are other functions.
_LIBM = re.compile(
    rf"(?<![\w:])(?P<std>std::|::)(?:{_TRANSCENDENTAL}|{_STD_ONLY})[fl]?\s*\("
    rf"|(?P<before>(?:\b[A-Za-z_]\w*|[>&*])\s+)?(?<![\w:.>])(?:{_TRANSCENDENTAL})[fl]?\s*\(")

# Pattern and message, for all C++ of the tree.
EVERYWHERE = (
    (re.compile(r"\bstd::\w+_distribution\b"),
     "a distribution of the standard library differs by machine; use common/random"),
    (re.compile(r"\brandom_device\b"), "seeds are fixed or printed, never the machine's"),
    (re.compile(r"\bstd::(mt19937(_64)?|minstd_rand0?|ranlux\w+|knuth_b|default_random_engine|"
                r"\w+_engine)\b"),
     "use the counter-based streams of common/random"),
    (re.compile(r"(?<![\w.>:])(?:std::)?(?:s?rand|[dlm]rand48)\s*\("),
     "use the counter-based streams of common/random"),
    (re.compile(r"^\s*#\s*if\s+0\b"), "dead code; git remembers what was"),
)

# The same for code whose results are stored.
IN_RESULTS = (
    (re.compile(r"\bAngleAxis\w*"), "Eigen's AngleAxis calls libm; use common/math's rotations"),
    (re.compile(r"\b(?:Matrix|RowVector|Vector|Array)X{1,2}(?:[a-z]{1,2}\b|\d)|\bEigen::Dynamic\b"),
     "reductions over dynamic sizes depend on alignment; use a fixed size"),
    (re.compile(r"\bboost::math::"), "Boost.Math is an oracle in tests, never a result"),
    (re.compile(r"\bstd::(?:transform_)?reduce\b|\bstd::execution\b"),
     "the order of this reduction is not fixed; write the loop"),
)

UNORDERED = re.compile(r"\bunordered_(?:multi)?(?:map|set)\b")
FLAGS = re.compile(r"-ffast-math|-Ofast|-march=native|-mtune=native|-funsafe-math-optimizations|"
                   r"-ffp-contract=fast|-fassociative-math")


def check(tree):
    for path in tree.files:
        if is_cpp(path):
            source = tree.source(path)
            for number, code in enumerate(source.code, 1):
                for message in _line(path, code):
                    yield Finding(path, number, message)
            for number in commented_code.lines(source):
                yield Finding(path, number, "commented-out code; git remembers what was (an "
                                            "example is indented under a line of prose)")
        elif is_cmake(path):
            for number, line in enumerate(without_comments(tree.text(path)).split("\n"), 1):
                for flag in FLAGS.findall(line):
                    yield Finding(path, number, f"{flag} makes results differ by machine")


def _line(path, code):
    if not code.strip():
        return
    for pattern, message in EVERYWHERE:
        if pattern.search(code):
            yield message
    if is_in(path, RESULTS):
        for pattern, message in IN_RESULTS:
            if pattern.search(code):
                yield message
        name = libm_call(code, wrapped=WRAPPED.fullmatch(path) is not None)
        if name:
            yield f"{name} of libm differs by machine; use common/math's elementary functions"
    if is_in(path, ORDERED) and UNORDERED.search(code) and "#" not in code:
        yield ("an unordered container in code whose order feeds results; use an ordered one, or "
               "say on the line why its order can't matter")


def libm_call(code, wrapped=False):
    """The first call of a libm transcendental on a line of code, or None.

    In a file that wraps them, only calls by std:: or :: are libm's.
    """
    for match in _LIBM.finditer(code):
        if not match.group("std"):
            before = (match.group("before") or "").strip()
            # A type before the name makes it a declaration of our own function.
            if wrapped or (before and _is_type(code[:match.start("before")] + before)):
                continue
        return re.search(r"((?:std::|::)?\w+)\s*\($", match.group(0)).group(1)
    return None


def _is_type(text):
    """Returns whether the text before a function's name is only a type."""
    return (re.fullmatch(r"\s*(?:\[\[\w+\]\]\s*)?[A-Za-z_][\w:<>,\s]*[\s&*]*", text) is not None
            and not re.search(r"\b(?:return|else|case|do|throw|co_return|not|and|or)\b", text))
