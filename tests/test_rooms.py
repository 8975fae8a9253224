"""Which room may import which, which libraries, and that each class has a name of its own.

The table is that of docs/architecture.md. Imports are read from the source: symbolic links are
resolved, and those within functions, under TYPE_CHECKING and by a string count too.
"""

import ast
import sys
from collections import defaultdict

from tests.support.import_graph import ROOT, all_imports, circles, module_files

PACKAGE = "warp_softbody."
# Words of the table for several rooms at once.
GROUPS = {"base": ("errors", "arrays", "inputs", "contact_mode"), "the package": ("warp_softbody",)}
# Room, a module or a folder with all that no row below it names: what it may import beside itself.
ROOMS: dict[str, tuple[str, ...]] = {
    "errors": (),
    "arrays": (),
    "inputs": ("errors", "arrays"),
    "contact_mode": ("inputs",),
    "atomic_files": (),
    "kernels": (),
    "device": ("errors", "kernels"),
    "body": ("base", "atomic_files"),
    "mesh_geometry": ("body",),
    "world": ("base", "device", "kernels", "body"),
    "linear": ("base", "device", "kernels"),
    "engine": ("base", "device", "kernels", "body", "world", "linear"),
    "controllers.qp": ("base",),
    "controllers.qpcc": ("base", "atomic_files", "controllers.qp"),
    "controllers.compiled": ("base", "device", "kernels", "controllers.qpcc"),
    "controllers": (
        *("base", "body", "world", "engine.reduced_dynamics"),
        *("controllers.qp", "controllers.qpcc", "controllers.compiled"),
    ),
    "run": ("base", "atomic_files", "device", "body", "world", "engine", "controllers"),
    "characters": ("base", "atomic_files", "body"),
    "scenes": ("base", "body", "world", "controllers", "characters"),
    "scene_files": (
        *("base", "atomic_files", "body", "world", "engine", "controllers", "run"),
        *("characters", "scenes"),
    ),
    "stage_exports": ("base", "atomic_files", "body", "world"),
    "environment": (*("base", "body", "world", "engine", "controllers", "run", "stage_exports"),),
    "accuracy": (
        *("base", "atomic_files", "body", "world", "engine", "controllers.control_options"),
        *("run", "scenes", "__init__"),
    ),
    "teaching": (*("base", "body", "world", "controllers", "run", "scenes", "__init__"),),
    "live": (
        *("base", "atomic_files", "body", "world", "engine", "controllers", "run"),
        "stage_exports",
    ),
    "cli": ("the package",),
    "__init__": ("the package",),
    "__main__": ("cli",),
    "benchmarks": ("the package",),
    "examples": ("the package",),
    "tests": ("the package", "benchmarks", "examples"),
}
# Libraries that only some rooms may import.
LIBRARIES = {
    "pxr": {"stage_exports", "benchmarks", "tests"},
    "warp": {"kernels", "device", "world", "linear", "engine", "run", "accuracy", "tests"},
}
# What a room may import from outside beside the standard library, where that is limited.
ONLY = {"kernels": {"warp"}}

FILES = module_files()
IMPORTS = {
    (imported.importer, imported.imported)
    for imported in all_imports()
    if imported.importer != imported.imported
}


def short(module: str) -> str:
    """The name as the table writes it, without that of the package."""
    return "__init__" if module == PACKAGE[:-1] else module.removeprefix(PACKAGE)


def within(module: str, room: str) -> bool:
    return module == room or module.startswith(room + ".")


def room_of(module: str) -> str:
    """The room of a module of the repository, the narrowest that holds it."""
    return max((room for room in ROOMS if within(short(module), room)), key=len)


def may_import(importer: str, imported: str) -> bool:
    """Whether the tables allow one module to import another, of the repository or from outside."""
    room = room_of(importer)
    if imported not in FILES:
        library = imported.partition(".")[0]
        limited = room in ONLY and library not in sys.stdlib_module_names
        allowed = not limited or library in ONLY[room]
        return allowed and room in LIBRARIES.get(library, {room})
    if imported.rpartition(".")[2].startswith("test_"):
        return False
    rooms = [part for word in ROOMS[room] for part in GROUPS.get(word, (word,))]
    return room_of(imported) == room or any(
        within(short(imported), other) or within(imported, other) for other in rooms
    )


def broken_rules() -> set[tuple[str, str]]:
    return {(short(a), short(b)) for a, b in IMPORTS if not may_import(a, b)}


def test_every_module_has_a_room() -> None:
    assert {room_of(module) for module in FILES} == set(ROOMS)


def test_no_room_imports_what_it_may_not() -> None:
    assert broken_rules() == set()


def test_rooms_import_in_one_direction() -> None:
    edges = {(room_of(a), room_of(b)) for a, b in IMPORTS if b in FILES}
    assert circles((a, b) for a, b in edges if a != b) == []


def test_modules_import_in_one_direction() -> None:
    found = circles((short(a), short(b)) for a, b in IMPORTS if b in FILES)
    assert found == []


def test_each_class_has_a_name_of_its_own() -> None:
    homes = defaultdict(list)
    for module, path in FILES.items():
        if module.partition(".")[0] in ("warp_softbody", "benchmarks"):
            for node in ast.parse(path.read_text(encoding="utf-8")).body:
                if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                    homes[node.name].append(module)
    assert {name: places for name, places in homes.items() if len(places) > 1} == {}


def test_the_docs_show_the_same_rooms() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    table = text.partition("## Rooms\n")[2].partition("\n## ")[0]
    rows = [line.strip("| ").split(" | ") for line in table.splitlines() if line.startswith("| `")]
    shown = {row[0].strip("`"): tuple(row[-1].split(", ")) for row in rows}
    assert shown == {room: allowed or ("nothing",) for room, allowed in ROOMS.items()}
