"""Mechanical mutations of one function: each changes one token or one expression within one line.

What cannot change a result is left alone: texts of errors and warnings, annotations, decorators, nested definitions
(they are functions of their own) and arguments that only guard (``strict=True`` of ``zip``).
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

ARITHMETIC: dict[type[ast.operator], tuple[str, str]] = {
    ast.Add: ("+", "-"),
    ast.Sub: ("-", "+"),
    ast.Mult: ("*", "/"),
    ast.Div: ("/", "*"),
}
LOGIC: dict[type[ast.AST], tuple[str, str]] = {
    ast.And: ("and", "or"),
    ast.Or: ("or", "and"),
    ast.BitAnd: ("&", "|"),
    ast.BitOr: ("|", "&"),
}
COMPARISONS: dict[type[ast.cmpop], tuple[str, str]] = {
    ast.Lt: ("<", "<="),
    ast.LtE: ("<=", "<"),
    ast.Gt: (">", ">="),
    ast.GtE: (">=", ">"),
    ast.Eq: ("==", "!="),
    ast.NotEq: ("!=", "=="),
    ast.Is: ("is", "is not"),
    ast.IsNot: ("is not", "is"),
}
EXTREMES = {"min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum"}
WAVES = {"sin": "cos", "cos": "sin"}
DROPPED = {"abs", "fabs", "sqrt"}

GUARDS = {
    *("strict", "copy", "allow_pickle", "exist_ok", "parents", "missing_ok", "check_finite", "stacklevel"),
    *("optimize", "threads"),
}
"""Keyword arguments whose value changes no result of correct input."""


@dataclass(frozen=True)
class Edit:
    """Replace columns ``start`` to ``end`` of a line (rows count from 1)."""

    row: int
    start: int
    end: int
    text: str
    operator: str


def edits(function: ast.FunctionDef, lines: Sequence[str], signatures: Mapping[str, Sequence[str]]) -> Iterator[Edit]:
    """Yield the mutations of a function; ``signatures`` has the annotations of functions' parameters by name."""
    for node in _code(function.body):
        for edit in _of_node(node, lines, signatures):
            if lines[edit.row - 1].isascii():
                yield edit
        if isinstance(node, ast.Return) and node.value is not None and _numeric(function, node.value):
            yield from _around(node.value, "-({})", "negated return", lines)


def _code(body: Sequence[ast.AST]) -> Iterator[ast.AST]:
    """Nodes that are executed and not only printed."""
    for node in body:
        if isinstance(node, ast.Raise | ast.Assert | ast.JoinedStr | ast.FunctionDef | ast.ClassDef | ast.Import):
            continue
        if isinstance(node, ast.keyword) and node.arg in GUARDS:
            continue
        if isinstance(node, ast.Call) and ast.unparse(node.func).endswith(("warn", "Error", "TypeVar", "cast")):
            continue
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "isinstance":
            node = node.args[0]
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]).endswith("writeable"):
            continue
        yield node
        if isinstance(node, ast.AnnAssign):
            yield from _code([] if node.value is None else [node.value])
        else:
            yield from _code(list(ast.iter_child_nodes(node)))


def _of_node(node: ast.AST, lines: Sequence[str], signatures: Mapping[str, Sequence[str]]) -> Iterator[Edit]:
    match node:
        case ast.BinOp(left, operator, right) if not _textual(left) and not _textual(right):
            for table, name in ((ARITHMETIC, "arithmetic"), (LOGIC, "and/or")):
                if type(operator) in table:
                    yield from _between(left, right, *table[type(operator)], name, lines)
        case ast.AugAssign(target, operator, value) if type(operator) in ARITHMETIC and not _textual(value):
            yield from _between(target, value, *ARITHMETIC[type(operator)], "arithmetic", lines)
        case ast.BoolOp(operator, values):
            for left, right in pairwise(values):
                yield from _between(left, right, *LOGIC[type(operator)], "and/or", lines)
        case ast.Compare(first, operators, comparators):
            for (left, right), each in zip(pairwise([first, *comparators]), operators, strict=True):
                if type(each) in COMPARISONS:
                    name = "not" if isinstance(each, ast.Is | ast.IsNot) else "comparison"
                    yield from _between(left, right, *COMPARISONS[type(each)], name, lines)
        case ast.UnaryOp(ast.Not()):
            yield Edit(node.lineno, node.col_offset, node.col_offset + len("not "), "", "not")
        case ast.If(test) | ast.IfExp(test) if isinstance(test, ast.Name | ast.Attribute | ast.Call):
            yield from _around(test, "not {}", "not", lines)
        case ast.Constant(bool() as value):
            yield Edit(node.lineno, node.col_offset, node.end_col_offset or 0, str(not value), "True/False")
        case ast.Constant(int() as value):
            yield Edit(node.lineno, node.col_offset, node.end_col_offset or 0, str(value + 1), "constant")
        case ast.Call(func, arguments):
            yield from _of_call(func, arguments, lines, signatures)


def _of_call(
    func: ast.expr, arguments: Sequence[ast.expr], lines: Sequence[str], signatures: Mapping[str, Sequence[str]]
) -> Iterator[Edit]:
    name = func.attr if isinstance(func, ast.Attribute) else func.id if isinstance(func, ast.Name) else ""
    end = func.end_col_offset or 0
    row = func.end_lineno or 0
    for table, operator in ((EXTREMES, "min/max"), (WAVES, "sin/cos")):
        if name in table:
            yield Edit(row, end - len(name), end, table[name], operator)
    if name in DROPPED and func.lineno == row:
        yield Edit(row, func.col_offset, end, "", "dropped call")
    kinds = signatures.get(name, ())
    for n, (a, b) in enumerate(pairwise(arguments)):
        same = n + 1 < len(kinds) and kinds[n] and kinds[n] == kinds[n + 1]
        one_line = a.lineno == b.end_lineno and not isinstance(a, ast.Starred) and not isinstance(b, ast.Starred)
        if same and one_line and ast.unparse(a) != ast.unparse(b):
            line = lines[a.lineno - 1]
            first, second = (line[each.col_offset : each.end_col_offset] for each in (a, b))
            middle = line[a.end_col_offset : b.col_offset]
            yield Edit(a.lineno, a.col_offset, b.end_col_offset or 0, second + middle + first, "swapped arguments")


def _between(left: ast.expr, right: ast.expr, old: str, new: str, name: str, lines: Sequence[str]) -> Iterator[Edit]:
    """Replace the operator that is written between two expressions of one line."""
    if left.end_lineno != right.lineno or left.end_col_offset is None:
        return
    middle = lines[right.lineno - 1][left.end_col_offset : right.col_offset]
    at = left.end_col_offset + middle.find(old)
    if middle.count(old) == 1:
        yield Edit(right.lineno, at, at + len(old), new, name)


def _around(node: ast.expr, form: str, name: str, lines: Sequence[str]) -> Iterator[Edit]:
    if node.lineno == node.end_lineno and node.end_col_offset is not None:
        inner = lines[node.lineno - 1][node.col_offset : node.end_col_offset]
        yield Edit(node.lineno, node.col_offset, node.end_col_offset, form.format(inner), name)


def _textual(node: ast.expr) -> bool:
    """Whether + and / of it join texts, lists or paths."""
    match node:
        case ast.JoinedStr() | ast.List() | ast.Tuple() | ast.Constant(str()) | ast.Constant(None):
            return True
        case ast.Name(name) | ast.Attribute(_, name):
            return name in {"folder", "path", "root", "directory", "name"}
        case ast.BinOp(left, _, right):
            return _textual(left) or _textual(right)
    return False


def _numeric(function: ast.FunctionDef, value: ast.expr) -> bool:
    """Whether a function returns one number or array (compiled kernels have no annotations)."""
    if isinstance(value, ast.Tuple | ast.Compare | ast.Constant | ast.BoolOp | ast.UnaryOp):
        return False
    if function.returns is None:
        return any("kernel" in ast.unparse(each) for each in function.decorator_list)
    return ast.unparse(function.returns) in {"float", "int", "Array", "NDArray[np.float64]", "NDArray[np.float32]"}
