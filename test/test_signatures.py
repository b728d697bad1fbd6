"""Claims about signatures: few positional parameters, and no long tuple whose numbers only have places."""

import ast

import pytest
from source_tree import FILES, tree_of

MOST_PARAMETERS = 8
MOST_NAMES = 4
BODY_VELOCITY = "nu"
"""Has six components with the standard letters u, v, w, p, q, r, which say more than six field names."""


def parameters_of(function):
    """Return how many arguments a function takes by their place."""
    return len(function.args.posonlyargs) + len(function.args.args)


def assignments_in(tree):
    """Return (target, value) of all assignments and loops."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign):
            yield from ((target, node.value) for target in node.targets)
        elif isinstance(node, ast.For | ast.comprehension):
            yield node.target, node.iter


def names_of(target):
    """Return the places that a target gives a name, without those that it ignores."""
    elements = target.elts if isinstance(target, ast.Tuple | ast.List) else []
    texts = [ast.unparse(element) for element in elements if not isinstance(element, ast.Starred)]
    return [text for text in texts if not text.startswith("_")]


def hides_names(value):
    """
    Return whether the meaning of a value's items depends on their places only: a call's result, or a
    variable.
    """
    if isinstance(value, ast.Call):
        return ast.unparse(value.func) not in ("zip", "enumerate")
    return isinstance(value, ast.Name | ast.Subscript) and ast.unparse(value) != BODY_VELOCITY


def long_signatures(tree):
    """Return line and size of every function with too many positional parameters."""
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.Lambda)]
    return [(node.lineno, parameters_of(node)) for node in functions if parameters_of(node) > MOST_PARAMETERS]


def long_unpackings(tree):
    """Return line and text of every long tuple that is unpacked by position."""
    return [
        (target.lineno, ast.unparse(target))
        for target, value in assignments_in(tree)
        if hides_names(value) and len(names_of(target)) > MOST_NAMES
    ]


@pytest.mark.parametrize("name", sorted(FILES))
def test_arguments_and_results_have_names(name):
    tree = tree_of(name)
    assert long_signatures(tree) == []
    assert long_unpackings(tree) == []


@pytest.mark.parametrize(
    ("text", "is_found"),
    [
        ("a, b, c, d, e = found()", True),
        ("a, b, c, d, e = gains", True),
        ("for a, b, c, d, e in rows: pass", True),
        ("x = [a for a, b, c, d, e in rows]", True),
        ("a, _, b, _, c, d = gains", False),
        ("a, b, c, d, *rest = gains", False),
        ("u, v, w, p, q, r = nu", False),
        ("for a, b, c, d, e in zip(*columns): pass", False),
        ("a, b, c, d, e = 1, 2, 3, 4, 5", False),
    ],
)
def test_a_long_tuple_is_found(text, is_found):
    assert bool(long_unpackings(ast.parse(text))) == is_found


def test_a_long_signature_is_found():
    assert long_signatures(ast.parse("def f(a, b, c, d, e, f, g, h, i): pass")) == [(1, 9)]
    assert long_signatures(ast.parse("def f(a, b, c, d, e, f, g, h, *, i): pass")) == []
