"""Numbers that a maintainer watches: ``python benchmarks/house.py [folder of sources]``.

Lines and files of Python; numbers among the module constants; functions with more than eight arguments; pairs
of equal blocks, which are runs of six or more lines of code, without blank lines, imports, comments and
docstrings, and as long as they can be.
"""

import argparse
import ast
import io
import tokenize
from collections import defaultdict
from itertools import combinations
from pathlib import Path

ARGUMENTS, BLOCK = 8, 6
SKIPPED = (
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENDMARKER,
)


def is_number(node):
    """Whether an expression is a number or a tuple of them, as far as one sees without running it."""
    match node:
        case ast.Constant(value=value):
            return isinstance(value, int | float | complex) and not isinstance(value, bool)
        case ast.UnaryOp(operand=operand):
            return is_number(operand)
        case ast.BinOp(left=left, right=right):
            return is_number(left) and is_number(right)
        case ast.Tuple(elts=parts):
            return all(map(is_number, parts)) and bool(parts)
        case ast.Attribute(value=value, attr=name):  # np.pi, np.finfo(float).eps
            return name in ("pi", "inf") or (name in ("eps", "tiny", "max") and "finfo" in ast.unparse(value))
        case ast.Call(func=ast.Name(id="float" | "int"), args=[value]):
            return is_number(value)
        case ast.Name(id=name):
            return name.isupper()
    return False


def constants(tree):
    """Names in capitals that a module sets to numbers."""
    for node in tree.body:
        if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None:
            continue
        for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
            pairs = [(target, node.value)]
            if isinstance(target, ast.Tuple):
                values = (
                    node.value.elts if isinstance(node.value, ast.Tuple) else [node.value] * len(target.elts)
                )
                pairs = list(zip(target.elts, values, strict=True))
            for name, value in pairs:
                if isinstance(name, ast.Name) and name.id.isupper() and is_number(value):
                    yield name.id


def long_signatures(tree):
    """Functions with more than eight arguments, of all kinds, and how many they have."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            spec = node.args
            names = [
                a.arg for a in (*spec.posonlyargs, *spec.args, *spec.kwonlyargs, spec.vararg, spec.kwarg) if a
            ]
            count = len(names) - (names[:1] in (["self"], ["cls"]))
            if count > ARGUMENTS:
                yield f"{node.name} ({count})"


def code_lines(text, tree):
    """The lines of code with their numbers: no comments, docstrings or imports, and one space for several."""
    left_out = set()
    for node in ast.walk(tree):
        is_docstring = isinstance(node, ast.Expr) and isinstance(getattr(node.value, "value", None), str)
        if is_docstring or isinstance(node, ast.Import | ast.ImportFrom):
            left_out.update(range(node.lineno, node.end_lineno + 1))
    words = defaultdict(list)
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in SKIPPED and token.start[0] not in left_out:
            words[token.start[0]].append(token.string)
    return [(line, " ".join(words[line])) for line in sorted(words)]


def equal_blocks(codes):
    """Pairs of places at which equal blocks begin, and their lengths, the longest first."""
    places = defaultdict(list)
    for path, code in codes.items():
        for k in range(len(code) - BLOCK + 1):
            places[tuple(line for _, line in code[k : k + BLOCK])].append((path, k))
    for same in places.values():
        for (path, i), (other, j) in combinations(same, 2):
            here, there = codes[path], codes[other]
            if i and j and here[i - 1][1] == there[j - 1][1]:
                continue  # within a longer block
            size = BLOCK
            while (
                max(i + size - len(here), j + size - len(there)) < 0
                and here[i + size][1] == there[j + size][1]
            ):
                size += 1
            yield size, f"{path}:{here[i][0]}", f"{other}:{there[j][0]}"


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, nargs="?", default=Path("src/isoembed"))
    parser.add_argument("--list", action="store_true", help="name the functions, blocks and constants")
    options = parser.parse_args()
    texts = {
        path.relative_to(options.folder): path.read_text() for path in sorted(options.folder.rglob("*.py"))
    }
    trees = {path: ast.parse(text) for path, text in texts.items()}
    lengths = {path: text.count("\n") for path, text in texts.items()}
    longest = max(lengths, key=lengths.get)
    numbers = [f"{path}: {name}" for path, tree in trees.items() for name in constants(tree)]
    many = [f"{path}: {name}" for path, tree in trees.items() for name in long_signatures(tree)]
    blocks = sorted(
        equal_blocks({path: code_lines(texts[path], trees[path]) for path in texts}), reverse=True
    )
    print(f"files                                   {len(texts):7}")
    print(f"lines                                   {sum(lengths.values()):7}")
    print(f"longest file                            {lengths[longest]:7}  {longest}")
    print(f"module constants that are numbers       {len(numbers):7}")
    print(f"functions with more than {ARGUMENTS} arguments    {len(many):7}")
    print(f"pairs of equal blocks of {BLOCK} lines or more {len(blocks):7}")
    if options.list:
        print(*numbers, *many, *(f"{size} lines: {here} = {there}" for size, here, there in blocks), sep="\n")


if __name__ == "__main__":
    main()
