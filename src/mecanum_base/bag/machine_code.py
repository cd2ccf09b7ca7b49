"""Machine code of kernels kept from process to process: loaded in hundredths of a second.

numba's own cache needs all of numba to be loaded first, which takes longer than replaying a
recording of some minutes. The file holds, for each kernel and kinds of arguments, the object code
that numba made and a small entry (:mod:`mecanum_base.bag.machine_entry`) that takes all
arguments as one row of 64-bit words:

    array      address, shape, strides       tuple, named tuple   its members
    int64      itself                        float64              its bits

The entry leaves in the first word whether all went well, in those behind it the whole numbers
the kernel returns. The file is only used by the same sources, compiler and processor.
"""

from __future__ import annotations

import contextlib
import ctypes
import importlib.machinery
import importlib.util
import json
import os
import pathlib
import struct
import sys
import sysconfig
import time
import types
import zlib
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from mecanum_base.core.estimation import prepared

MAGIC = b'mecanum machine code 1\n'
_HEAD = struct.Struct('<II')  # size of the header, checksum of all behind it
_FLOAT, _INT = struct.Struct('<d'), struct.Struct('<q')
_NAME = 'kernels'  # begin of all file names
_OLD = 3600.0  # s after which nobody is still writing a file
_held: list[Any] = []  # engines: their code stays in memory as long as they do


@dataclass(frozen=True, slots=True)
class Entry:
    """One kernel for one kind of arguments: name of the kernel, kinds, number of results, name
    of the entry, object code in the order in which it is linked."""

    kernel: str
    kinds: str
    results: int
    symbol: str
    objects: tuple[bytes, ...]


def words_of(arguments: tuple[Any, ...]) -> tuple[str, list[int]] | None:
    """Kinds of the arguments and their words; None where one is of no kind that is known."""
    kinds: list[str] = []
    words: list[int] = []

    def add(value: Any) -> bool:
        if isinstance(value, np.ndarray):
            flags = value.flags
            kinds.append(f'{value.dtype.str}{value.ndim}{"C" if flags.c_contiguous else "A"}'
                         f'{"" if flags.writeable and flags.aligned else "r"}')
            words.extend((value.__array_interface__['data'][0], *value.shape, *value.strides))
        elif isinstance(value, tuple):
            kinds.append(f'{type(value).__name__}(')
            if not all(map(add, value)):
                return False
            kinds.append(')')
        elif type(value) in (int, np.int64):
            kinds.append('i')
            words.append(int(value))
        elif isinstance(value, float):
            kinds.append('f')
            words.append(_INT.unpack(_FLOAT.pack(value))[0])
        else:
            return False
        return True

    return (' '.join(kinds), words) if all(map(add, arguments)) else None


def file_name() -> pathlib.Path | None:
    """Where the code for this processor and these sources is; None where it can be nowhere.

    The name tells the installation (place, Python, processor) and then everything that the code
    depends on: files of the same installation with another name behind it are of no use any more.
    """
    if sys.platform != 'linux' or sysconfig.get_config_var('Py_GIL_DISABLED'):
        return None
    numba = importlib.util.find_spec('numba')
    if numba is None or numba.origin is None or importlib.util.find_spec('llvmlite') is None:
        return None
    llvmlite, llvm = (importlib.import_module(name) for name in ('llvmlite', 'llvmlite.binding'))
    root = pathlib.Path(__file__).resolve().parents[1]
    processor = [llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()]
    owner = [str(root), sys.prefix, *processor]
    text = [prepared.sources(), sys.version, np.__version__, llvmlite.__version__, *processor,
            pathlib.Path(numba.origin).with_name('_version.py').read_text()]
    text += [part.read_text() for part in sorted((root / 'bag').glob('*_kernel.py'))]
    own = root / 'bag' / '__pycache__'
    place = os.environ.get('NUMBA_CACHE_DIR') or (
        own if os.access(own if own.exists() else own.parent, os.W_OK) else
        pathlib.Path(os.environ.get('XDG_CACHE_HOME') or pathlib.Path.home() / '.cache')
        / 'mecanum_base')
    return pathlib.Path(place) / f'{_NAME}.{_checksum(owner)}.{_checksum(text)}.machine_code'


def _checksum(text: list[str]) -> str:
    return f'{zlib.crc32(repr(text).encode()):08x}'


def remove_stale(path: pathlib.Path) -> None:
    """Remove what this installation left beside ``path``, a name of :func:`file_name`.

    Whole files at once: who still uses one has read it. Parts of files only after a while:
    another process may be writing one.
    """
    owner = '.'.join(path.name.split('.')[:2])
    for other in path.parent.glob(f'{owner}.*'):
        with contextlib.suppress(OSError):  # gone already, or not ours to remove
            written = other.suffix == path.suffix
            if other.name != path.name and (written or time.time() - other.stat().st_mtime > _OLD):
                other.unlink()


def read(path: pathlib.Path) -> list[Entry]:
    """The entries of a file; none where it is missing or damaged."""
    try:
        data = path.read_bytes()
        size, checksum = _HEAD.unpack_from(data, len(MAGIC))
        at = len(MAGIC) + _HEAD.size
        if not data.startswith(MAGIC) or zlib.crc32(data[at:]) != checksum:
            return []
        head = json.loads(data[at:at + size])
    except (OSError, struct.error, ValueError):
        return []
    at += size
    parts = []
    for length in head[0]:
        parts.append(data[at:at + length])
        at += length
    return [Entry(**{**item, 'objects': tuple(parts[k] for k in item['objects'])})
            for item in head[1]]


def write(path: pathlib.Path, entries: list[Entry]) -> None:
    """Write a file that is whole or not there; OSError where it cannot be written."""
    parts = list(dict.fromkeys(part for entry in entries for part in entry.objects))
    head = json.dumps([[len(part) for part in parts], [
        {**asdict(entry), 'objects': [parts.index(part) for part in entry.objects]}
        for entry in entries]]).encode()
    rest = head + b''.join(parts)
    path.parent.mkdir(parents=True, exist_ok=True)
    half = path.with_suffix(f'.{os.getpid()}')
    half.write_bytes(MAGIC + _HEAD.pack(len(head), zlib.crc32(rest)) + rest)
    half.replace(path)


def load(path: pathlib.Path | None = None) -> bool:
    """Make the kernels of the file callable, before they are imported; False without one."""
    path = path or file_name()
    entries = [] if path is None else read(path)
    if entries:
        calls: dict[str, dict[str, Callable[..., Any]]] = {}
        engine = _engine(entries)
        for entry in entries:
            calls.setdefault(entry.kernel, {})[entry.kinds] = _call(
                entry, engine.get_function_address(entry.symbol))
        prepared.CODE.update({name: _choice(some) for name, some in calls.items()})
        _held.append(engine)
    return bool(entries)


def _choice(calls: dict[str, Callable[..., Any]]) -> Callable[..., Any]:
    def call(*arguments: Any) -> Any:
        found = words_of(arguments)
        if found is None or found[0] not in calls:
            return NotImplemented
        return calls[found[0]](found[1])

    return call


def _call(entry: Entry, address: int) -> Callable[[list[int]], Any]:
    function = ctypes.CFUNCTYPE(None, ctypes.c_void_p)(address)  # others run meanwhile
    results = entry.results

    def call(words: list[int]) -> Any:
        room = (ctypes.c_int64 * max(len(words), 1 + results))(*words)
        function(ctypes.addressof(room))
        if not room[0]:
            raise RuntimeError(f'{entry.kernel} has failed')
        return tuple(room[1:1 + results]) if results > 1 else room[1] if results else None

    return call


def _engine(entries: list[Entry]) -> Any:
    """What holds the linked machine code, with all that numba's code calls made known to it."""
    llvm = importlib.import_module('llvmlite.binding')
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    for name, address in _symbols().items():
        llvm.add_symbol(name, address)
    target = llvm.Target.from_default_triple().create_target_machine(jit=True,
                                                                     codemodel='jitdefault')
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(''), target)
    for part in dict.fromkeys(part for entry in entries for part in entry.objects):
        engine.add_object_file(llvm.ObjectFileRef.from_data(part))
    engine.finalize_object()
    return engine


def _symbols() -> dict[str, int]:
    """Addresses of what numba makes known to its code: its C functions, exceptions, memory."""
    runtime = _extension('numba.core.runtime._nrt_python')
    runtime.memsys_use_cpython_allocator()
    found = {'_Py_NoneStruct': id(None)}
    for module in ('numba._helperlib', 'numba._dynfunc'):
        found.update({f'numba_{name}': address
                      for name, address in _extension(module).c_helpers.items()})
    found.update({name if name.startswith('_') else f'NRT_{name}': address
                  for name, address in runtime.c_helpers.items()})
    found.update({f'PyExc_{kind.__name__}': id(kind)
                  for kind in vars(__import__('builtins')).values()
                  if isinstance(kind, type) and issubclass(kind, BaseException)})
    return found


def _extension(name: str) -> types.ModuleType:
    """An extension module of numba without the package around it."""
    if name in sys.modules:
        return sys.modules[name]
    numba = importlib.util.find_spec('numba')
    assert numba is not None and numba.submodule_search_locations
    folder = pathlib.Path(numba.submodule_search_locations[0], *name.split('.')[1:-1])
    finder = importlib.machinery.FileFinder(str(folder), (
        importlib.machinery.ExtensionFileLoader, importlib.machinery.EXTENSION_SUFFIXES))
    spec = finder.find_spec(name.rpartition('.')[2])
    assert spec is not None and spec.origin is not None
    loader = importlib.machinery.ExtensionFileLoader(name, spec.origin)
    whole = importlib.util.spec_from_loader(name, loader)
    assert whole is not None
    module = importlib.util.module_from_spec(whole)
    loader.exec_module(module)
    return module
