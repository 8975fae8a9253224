"""Pages of the site that stand elsewhere: the README, top-level pages, examples and the API.

MkDocs calls `on_files` once a build and `on_page_markdown` for each page. The pages of the API are
made from the public names, as they stand in the ``__all__`` of each module, and sorted by the room
that a name comes from.
"""

import re
from collections import defaultdict
from pathlib import Path

import griffe
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parents[1]
PACKAGE = "warp_softbody"
TOP_LEVEL = {
    "README.md": "index.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
}
API = {
    "package": "",
    "controllers": "controllers",
    "objectives": "controllers.objectives",
    "qpcc": "controllers.qpcc",
    "stage_exports": "stage_exports",
    "live": "live",
    "characters": "characters",
    "scenes": "scenes",
    "scene_files": "scene_files",
    "errors": "errors",
}
ROOMS = {
    "body": "Bodies",
    "world": "The world",
    "run": "Simulations",
    "engine": "A loop of your own",
    "controllers": "Control",
    "stage_exports": "Stages",
}


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that do not stand in the folder of the documentation."""
    for source, page in TOP_LEVEL.items():
        text = (ROOT / source).read_text(encoding="utf-8")
        files.append(File.generated(config, page, content=_links_of_the_site(text)))
    files.append(File.generated(config, "examples.md", content=_examples()))
    package = griffe.load(PACKAGE, search_paths=[str(ROOT)])
    for page, module in API.items():
        content = _api_page(package[module] if module else package)
        files.append(File.generated(config, f"api/{page}.md", content=content))
    return files


def on_page_markdown(markdown: str, **_: object) -> str:
    """Lead links of the documentation's own pages to the top-level pages of the site."""
    for source, page in TOP_LEVEL.items():
        markdown = markdown.replace(f"](../{source}", f"]({page}")
    return markdown


def _links_of_the_site(text: str) -> str:
    """A top-level page with its links as the site has them."""
    text = re.sub(r"\]\(docs/", "](", text)
    text = re.sub(r"\]\(examples/(\w+)\.py\)", r"](examples.md#\1)", text)
    for source, page in TOP_LEVEL.items():
        text = text.replace(f"]({source}", f"]({page}")
    # files that the site does not hold are named, not linked
    return re.sub(r"\[([^\]]+)\]\((?:LICENSE|CITATION\.cff)\)", r"`\1`", text)


def _examples() -> str:
    """All example scripts on one page."""
    parts = ["# Examples\n\nEach script is also run by a test.\n"]
    for path in sorted((ROOT / "examples").glob("*.py")):
        source = path.read_text(encoding="utf-8")
        parts.append(f"## {path.stem}\n\n```python\n{source}```\n")
    return "\n".join(parts)


def _api_page(module: griffe.Object | griffe.Alias) -> str:
    """The public names of a module, under a heading for each room."""
    names: dict[str, list[str]] = defaultdict(list)
    for name in sorted(_public_names(module), key=str.casefold):
        member, path = module.members[name], f"{module.path}.{name}"
        if not member.is_alias and member.is_module:
            if name not in member.members:
                continue
            # a function that stands in a module of its own name
            path = f"{member.path}.{name}"
        names[_room(module, member)].append(f"::: {path}\n")
    parts = [f"# `{module.path}`\n", module.docstring.value if module.docstring else "", ""]
    rooms = [room for room in ROOMS.values() if room in names]
    for room in [*rooms, *(room for room in names if room not in rooms)]:
        if len(names) > 1:
            parts.append(f"## {room}\n")
        parts += names[room]
    return "\n".join(parts)


def _public_names(module: griffe.Object | griffe.Alias) -> list[str]:
    """What ``__all__`` names, else what is defined there without an underscore."""
    if module.exports is not None:
        return [str(name) for name in module.exports]
    return [
        name
        for name, member in module.members.items()
        if not name.startswith("_")
        and not member.is_alias
        and (member.is_class or member.is_function)
    ]


def _room(module: griffe.Object | griffe.Alias, member: griffe.Object | griffe.Alias) -> str:
    """The heading under which a name stands; only the package's own names have several."""
    if module.path != PACKAGE or not member.is_alias:
        return module.path
    room = member.target_path.split(".")[1]
    return ROOMS.get(room, "The world")
