"""Which module of the repository imports which, read from the source without running it."""

import ast
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# The folders that hold modules, and the names under which those are imported.
PACKAGES = {
    "warp_softbody": "warp_softbody",
    "kernels": "warp_softbody.kernels",
    "controllers": "warp_softbody.controllers",
    "stage_exports": "warp_softbody.stage_exports",
    "benchmarks": "benchmarks",
    "examples": "examples",
    "tests": "tests",
}
# Functions whose first argument, a string, is the name of a module to import.
IMPORTERS = {"import_module", "__import__", "importorskip"}


@dataclass(frozen=True, order=True)
class Import:
    """Module `importer`, in the line `line` of its file, needs module `imported`."""

    importer: str
    imported: str
    line: int


def module_files() -> dict[str, Path]:
    """Name and file of every module of the repository, each once however it is linked."""
    files = {}
    for folder, package in PACKAGES.items():
        for path in sorted((ROOT / folder).rglob("*.py")):
            resolved = path.resolve()
            if resolved.relative_to(ROOT).parts[0] == folder:  # a link leads to another folder
                parts = resolved.relative_to(ROOT / folder).with_suffix("").parts
                files[".".join((package, *(part for part in parts if part != "__init__")))] = path
    return files


def imports_of(module: str, path: Path, modules: Iterable[str]) -> Iterator[Import]:
    """Every import of the file, also within functions, under TYPE_CHECKING and in strings.

    `from package import name` counts for the module `package.name` where there is one, else for
    the package. A name that no module of the repository has is given in full.
    """
    known = set(modules)
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    tree = ast.parse(path.read_text(encoding="utf-8"))
    strings = {n.value for n in ast.walk(tree) if isinstance(n, ast.Constant)}
    words = {value for value in strings if isinstance(value, str)}
    for node in ast.walk(tree):
        names: Iterable[str] = ()
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = _imported_from(node, package, known)
        elif isinstance(node, ast.Call) and node.args and _called(node) in IMPORTERS:
            names = _named_by(node.args[0], module, package, words, known)
        else:
            continue
        for name in names:
            yield Import(module, name, node.lineno)
    for text in words:  # scripts that are handed to another process
        for name in re.findall(r"^(?:from|import) ([\w.]+)", text, re.MULTILINE):
            if name in known:
                yield Import(module, name, 0)


def _imported_from(node: ast.ImportFrom, package: str, known: set[str]) -> set[str]:
    """The modules that `from ... import ...` needs."""
    source = node.module or ""
    if node.level:
        above = package.split(".")[: len(package.split(".")) - node.level + 1]
        source = ".".join([*above, *filter(None, [source])])
    members = {f"{source}.{alias.name}" for alias in node.names}
    return {member if member in known else source for member in members}


def _called(node: ast.Call) -> str:
    """The last part of the name of the function that is called."""
    if isinstance(node.func, ast.Attribute):
        return node.func.attr
    return node.func.id if isinstance(node.func, ast.Name) else ""


def _named_by(
    argument: ast.expr, module: str, package: str, words: set[str], known: set[str]
) -> set[str]:
    """The modules that a string names.

    Of f"start.{end}" these are the modules whose end stands as a string in the same file.
    """
    if isinstance(argument, ast.Constant) and isinstance(argument.value, str):
        name = argument.value
        return {package + name if name.startswith(".") else name}
    if not isinstance(argument, ast.JoinedStr):
        return set()
    start = ""
    for part in argument.values:
        if isinstance(part, ast.Constant):
            start += str(part.value)
        elif isinstance(part, ast.FormattedValue) and ast.unparse(part.value) == "__name__":
            start += module
        else:
            break
    return {start + word for word in words if start + word in known}


def all_imports() -> list[Import]:
    """Every import of every module of the repository."""
    files = module_files()
    return sorted({i for name, path in files.items() for i in imports_of(name, path, files)})


def circles(edges: Iterable[tuple[str, str]]) -> list[list[str]]:
    """The sorted sets of nodes that reach one another along the edges (Tarjan's algorithm)."""
    following: dict[str, set[str]] = {}
    for start, end in edges:
        following.setdefault(start, set()).add(end)
        following.setdefault(end, set())
    order: dict[str, int] = {}
    lowest: dict[str, int] = {}
    stack: list[str] = []
    found: list[list[str]] = []

    def visit(node: str) -> None:
        order[node] = lowest[node] = len(order)
        stack.append(node)
        for other in sorted(following[node]):
            if other not in order:
                visit(other)
            if other in stack:
                lowest[node] = min(lowest[node], lowest[other])
        if lowest[node] == order[node]:
            component = stack[stack.index(node) :]
            del stack[stack.index(node) :]
            if len(component) > 1:
                found.append(sorted(component))

    for node in sorted(following):
        if node not in order:
            visit(node)
    return found
