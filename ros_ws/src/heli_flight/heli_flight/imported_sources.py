"""Which files of a package a module depends on, read from the text of its imports."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from importlib.util import resolve_name
from pathlib import Path


def imported_sources(root: Path, module: str) -> tuple[str, ...]:
    """The module's file and all files of its package that it imports, their imports included.

    Imports count at any depth of the text, those within functions, too; nothing is executed.

    Args:
        root: folder of the package, of its name.
        module: name within the package, `plan` or `nodes.supervisor_node`.

    Returns:
        Paths relative to the folder, sorted.

    Raises:
        FileNotFoundError: no such module.
    """
    found: set[Path] = set()
    todo = [_file(root, f"{root.name}.{module}")]
    while todo:
        path = todo.pop()
        if path in found:
            continue
        found.add(path)
        folder = ".".join((root.name, *path.parent.relative_to(root).parts))
        for name in _imports(path.read_text(encoding="utf-8"), folder):
            parts = name.split(".")
            if parts[0] == root.name:
                begun = [".".join(parts[: count + 1]) for count in range(len(parts))]
                todo += filter(Path.is_file, (_file(root, each) for each in begun))
    return tuple(sorted(path.relative_to(root).as_posix() for path in found))


def _file(root: Path, name: str) -> Path:
    """Where a name of the package would be, were it a module."""
    path = root.joinpath(*name.split(".")[1:])
    return path / "__init__.py" if path.is_dir() else path.parent / f"{path.name}.py"


def _imports(text: str, folder: str) -> Iterator[str]:
    """Everything imported by a module of a folder, by full name; the end need not be a module."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = resolve_name("." * node.level + (node.module or ""), folder)
            yield from (f"{above}.{alias.name}" for alias in node.names)
