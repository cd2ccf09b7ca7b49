"""Which files a bag consists of: one file, a rosbag2 folder, or several of either."""

from __future__ import annotations

import os
import pathlib
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import yaml

from mecanum_base.core.errors import BagError

ENDINGS = ('.mcap', '.db3', '.mcap.zstd', '.db3.zstd')
_LARGEST_METADATA = 1 << 24


@dataclass(frozen=True, slots=True)
class BagFiles:
    """Files of a bag in the order of recording; ``packed_messages``: each payload is zstd."""

    paths: tuple[str, ...]
    notes: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()
    packed_messages: bool = False


def files_of(path: str | os.PathLike[str]) -> BagFiles:
    """The files behind one path given by a user; BagError where there is no bag."""
    place = pathlib.Path(path)
    if not place.exists():
        raise BagError(f'{path}: does not exist')
    if place.is_file():
        return BagFiles((str(place),))
    if not place.is_dir():
        raise BagError(f'{path}: is neither a file nor a folder')
    present = sorted((p.name for p in place.iterdir() if p.name.endswith(ENDINGS)), key=_natural)
    metadata = place / 'metadata.yaml'
    if not metadata.is_file():
        if not present:
            raise BagError(f'{path}: holds no bag (no .mcap, no .db3, no metadata.yaml)')
        return BagFiles(tuple(str(place / n) for n in present), ('there is no metadata.yaml',))
    try:
        info = _information(metadata)
    except (ValueError, OSError, RecursionError) as error:
        if not present:
            raise BagError(f'{metadata}: cannot be used: {error}') from None
        return BagFiles(tuple(str(place / n) for n in present),
                        (f'metadata.yaml is not usable ({error})',))
    named = [pathlib.PurePath(str(n)).name for n in info.get('relative_file_paths') or []]
    found = [n for n in named if (place / n).is_file()] or present
    if not found:
        raise BagError(f'{path}: the files named in metadata.yaml are missing: '
                       f'{", ".join(named) or "none is named"}')
    missing = tuple(n for n in named if n not in found)
    packed = (str(info.get('compression_mode', '')).upper() == 'MESSAGE'
              and 'zstd' in str(info.get('compression_format', '')).lower())
    return BagFiles(tuple(str(place / n) for n in found), (), missing, packed)


def bags_under(paths: Sequence[str]) -> tuple[str, ...]:
    """Every bag among ``paths``: files and bag folders as they are, other folders searched."""
    found: list[str] = []
    for path in paths:
        place = pathlib.Path(path)
        if not place.is_dir() or _is_bag(place):
            found.append(str(path))
            continue
        inside: list[str] = []
        for root, folders, names in os.walk(place):
            here = pathlib.Path(root)
            if (here / 'metadata.yaml').is_file() and _is_bag(here):
                inside.append(str(here))
                folders.clear()
            else:
                inside += [str(here / n) for n in names if n.endswith(ENDINGS)]
        if not inside:
            raise BagError(f'{path}: no bag below this folder')
        found += sorted(inside, key=_natural)
    return tuple(dict.fromkeys(found))


def _is_bag(place: pathlib.Path) -> bool:
    return (place / 'metadata.yaml').is_file() and any(
        p.name.endswith(ENDINGS) for p in place.iterdir())


def _natural(name: str) -> list[Any]:
    return [int(part) if part.isdigit() else part for part in re.split(r'(\d+)', name)]


def _information(path: pathlib.Path) -> dict[str, Any]:
    if path.stat().st_size > _LARGEST_METADATA:
        raise ValueError('it is larger than any real one')
    try:
        document = yaml.safe_load(path.read_text(encoding='utf-8'))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ValueError(str(error).splitlines()[0]) from None
    info = document.get('rosbag2_bagfile_information') if isinstance(document, dict) else None
    if not isinstance(info, dict):
        raise ValueError('no rosbag2_bagfile_information in it')
    if not isinstance(info.get('relative_file_paths') or [], list):
        raise ValueError('relative_file_paths is no list')
    return info
