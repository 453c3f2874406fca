"""Docstrings in src/ begin with what a thing is or does, not with a clause or a preposition."""

import ast

from places import ROOT

PACKAGE = ROOT / "src" / "isoembed"
CLAUSES = {"How", "That", "These", "This", "Those", "What", "When", "Where", "Which", "Who", "Whose", "Why"}
PREPOSITIONS = {"As", "At", "By", "For", "From", "In", "Of", "So", "Such", "To", "With"}
"""First words that name nothing.  "Whether" is for truth values, and "See" refers to another docstring."""


def first_lines(source: str) -> list[tuple[int, str]]:
    """Numbers and first lines of the docstrings of modules, classes, functions and constants."""
    found = []
    nodes: list[ast.Module | ast.ClassDef | ast.FunctionDef] = [ast.parse(source)]
    while nodes:
        for statement in nodes.pop().body:
            if isinstance(statement, ast.ClassDef | ast.FunctionDef):
                nodes.append(statement)
            text = statement.value if isinstance(statement, ast.Expr) else None
            if isinstance(text, ast.Constant) and isinstance(text.value, str):
                found.append((text.lineno, text.value.strip().splitlines()[0]))
    return found


def wrong(source: str) -> list[tuple[int, str]]:
    """First lines of docstrings that begin with a clause or a preposition."""
    return [
        (number, line)
        for number, line in first_lines(source)
        if line.split()[0].rstrip(",:;") in CLAUSES | PREPOSITIONS
    ]


def test_clauses_are_found_wherever_they_stand():
    source = '"""From lengths."""\nN = 3\n"""How many."""\nclass A:\n    """See `B`."""\n    def f(x):\n'
    source += '        """Of x."""\n'
    assert [number for number, _ in sorted(wrong(source))] == [1, 3, 7]


def test_docstrings_begin_with_a_noun_or_a_verb():
    found = {
        str(path.relative_to(PACKAGE)): wrong(path.read_text(encoding="utf-8"))
        for path in sorted(PACKAGE.rglob("*.py"))
    }
    assert {name: lines for name, lines in found.items() if lines} == {}
