"""Controllers that come with this package, by the format in the first line of their files."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from heli_common.errors import InputError
from heli_common.model_file import check_keys, read_mapping, read_word


def shipped(kind: str) -> dict[str, Path]:
    """Names and files of the shipped controllers of a format.

    Args:
        kind: format, as in the first line of a file.
    """
    folder = Path(str(resources.files("heli_control"))) / "controllers"
    found = {}
    for path in sorted(folder.glob("*.yaml")):
        with path.open(encoding="utf-8") as stream:
            if stream.readline().strip() == f"format: {kind}":
                found[path.stem] = path
    return found


def find_controller(name_or_path: str, kind: str) -> Path:
    """The file of a controller, by its path or by the name of a shipped one; a file goes first.

    Args:
        name_or_path: of the controller.
        kind: format of the shipped ones that count.

    Raises:
        InputError: neither.
    """
    path = Path(name_or_path)
    if path.is_file():
        return path
    known = shipped(kind)
    if name_or_path not in known:
        allowed = "a file, or one of " + ", ".join(known)
        raise InputError(f"{name_or_path!r} is no controller", allowed=allowed, key="controller")
    return known[name_or_path]


def read_plant(value: object, path: Path) -> tuple[str, str]:
    """Name and hash of the plant that a controller file says it is for.

    Args:
        value: what stands under `plant`.
        path: of the file, for errors.

    Raises:
        InputError: no mapping of exactly these two texts.
    """
    plant = read_mapping(value, path, "plant")
    check_keys(plant, ("name", "hash"), (), path, "plant.")
    return read_word(plant["name"], path, "plant.name"), read_word(plant["hash"], path, "plant.hash")


def require_plant(path: Path, name: str, given: str, wanted: str) -> None:
    """Refuse a controller that was designed for another plant.

    Args:
        path: of its file.
        name: of the plant it is for.
        given: hash of the plant it is for.
        wanted: hash of the plant it must be for; empty: any.

    Raises:
        InputError: the hashes differ.
    """
    if wanted and given != wanted:
        raise InputError(f"{given!r} is another plant ({name})", allowed=wanted, file=path, key="plant.hash")
