"""Makes the file of :mod:`mecanum_base.bag.machine_code` from what numba has compiled and cached.

numba keeps object code of every kernel; all that is made here is an entry for each that Python
calls: a function that puts the arguments together from words and calls the kernel.
"""

from __future__ import annotations

import contextlib
import importlib
import re
import subprocess
import sys
from collections.abc import Sequence
from typing import Any

from mecanum_base.bag.machine_code import Entry, file_name, read, remove_stale, write

# those that a replay calls
KERNELS = ('core.estimation.run_kernel.run', 'core.estimation.retrace.retrace',
           'bag.row_text_kernel.rows_text')
_TRY = ('import pathlib, sys; from mecanum_base.bag.machine_code import load; '
        'sys.exit(not load(pathlib.Path(sys.argv[1])))')


def keep() -> bool:
    """Keep the kernels that this process has used; False where that is not possible.

    Fails without a word: the next process then begins as slowly as this one.
    """
    try:
        path = file_name()
        if path is None:
            return False
        kept = read(path)
        entries = list(kept)
        for name in KERNELS:
            module, _, kernel = f'mecanum_base.{name}'.rpartition('.')
            entries += entries_of(getattr(importlib.import_module(module), kernel),
                                  f'{module}.{kernel}', kept)
        if len(entries) == len(kept):
            return False
        # tried by another process: code that cannot be linked ends the one that loads it
        trial = path.with_name(f'{path.name}.trial')
        write(trial, entries)
        try:
            subprocess.run([sys.executable, '-c', _TRY, str(trial)], check=True, timeout=60,
                           stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                           stderr=subprocess.DEVNULL)
            trial.replace(path)
            remove_stale(path)
        finally:
            trial.unlink(missing_ok=True)
        return True
    except Exception:
        return False


def entries_of(dispatcher: Any, name: str, kept: Sequence[Entry] = ()) -> list[Entry]:
    """An entry for each kind of arguments that ``dispatcher`` was called with and ``kept`` lacks.

    It takes a quarter of a minute for the filter.
    """
    known = {entry.kinds for entry in kept if entry.kernel == name}
    context = dispatcher.targetctx
    cache = dispatcher._cache
    found: list[Entry] = []
    for signature in dispatcher.nopython_signatures:
        kinds = ' '.join(map(_kind, signature.args))
        if kinds in known:
            continue
        data = cache._cache_file.load(cache._index_key(signature.args, context.codegen()))
        (_, _, (kernel, bitcode)), function = data[0], data[1]
        with contextlib.suppress(AttributeError, RuntimeError):  # else as numba has made it
            kernel = tightened(bitcode, function.mangled_name, context.codegen()._tm)
        symbol = f'entry_{len(known) + len(found)}_{name.replace(".", "_")}'
        results, entry = _entry(context, function, signature.args, symbol)
        found.append(Entry(name, kinds, results, symbol, (entry, kernel)))
    return found


def _kind(kind: Any) -> str:
    """As machine_code.words_of names it; ValueError for a kind that has no words."""
    types = _module('numba.core.types')
    if isinstance(kind, types.Array):
        if kind.layout not in 'CA':
            raise ValueError(kind)
        dtype = _module('numba.np.numpy_support').as_dtype(kind.dtype)
        return (f'{dtype.str}{kind.ndim}{kind.layout}'
                f'{"" if kind.mutable and kind.aligned else "r"}')
    if isinstance(kind, types.BaseTuple):
        name = kind.instance_class.__name__ if isinstance(kind, types.BaseNamedTuple) else 'tuple'
        return ' '.join([f'{name}(', *map(_kind, kind), ')'])
    if kind == types.int64:
        return 'i'
    if kind == types.float64:
        return 'f'
    raise ValueError(kind)


def _entry(context: Any, function: Any, kinds: Any, symbol: str) -> tuple[int, bytes]:
    """Number of results and object code of the entry of the kernel described by ``function``."""
    ir, types = _module('llvmlite.ir'), _module('numba.core.types')
    cells, arrays = _module('numba.core.cgutils'), _module('numba.np.arrayobj')
    word = ir.IntType(64)
    codegen = context.codegen()
    module = codegen.create_library(symbol).create_ir_module(symbol)
    entry = ir.Function(module, ir.FunctionType(ir.VoidType(), [word.as_pointer()]), symbol)
    builder = ir.IRBuilder(entry.append_basic_block())
    place = [0]

    def cell(index: int) -> Any:
        return cells.gep_inbounds(builder, entry.args[0], index)

    def following() -> Any:
        place[0] += 1
        return builder.load(cell(place[0] - 1))

    def value(kind: Any) -> Any:
        if isinstance(kind, types.Array):
            array = context.make_array(kind)(context, builder)
            size = context.get_abi_sizeof(context.get_data_type(kind.dtype))
            data = builder.inttoptr(following(), array.data.type)
            shape = [following() for _ in range(kind.ndim)]
            strides = [following() for _ in range(kind.ndim)]
            arrays.populate_array(array, data=data, shape=shape, strides=strides, meminfo=None,
                                  itemsize=context.get_constant(types.intp, size))
            return array._getvalue()
        if isinstance(kind, types.BaseTuple):
            return context.make_tuple(builder, kind, [value(part) for part in kind])
        if isinstance(kind, types.Float):
            return builder.bitcast(following(), ir.DoubleType())
        return following()

    arguments = [value(kind) for kind in kinds]
    status, result = context.call_conv.call_function(
        builder, context.declare_function(module, function), function.restype,
        function.argtypes, arguments)
    whole = function.restype
    if whole == types.none:
        results = []
    elif isinstance(whole, types.BaseTuple) and all(kind == types.int64 for kind in whole):
        results = [builder.extract_value(result, k) for k in range(len(whole))]
    elif whole == types.int64:
        results = [result]
    else:
        raise ValueError(whole)
    builder.store(builder.zext(status.is_ok, word), cell(0))
    for index, part in enumerate(results):
        builder.store(part, cell(1 + index))
    builder.ret_void()
    return len(results), _object(codegen, module)


# How references to the arrays are counted that a kernel makes for itself. numba counts with atomic
# operations, since its arrays may be shared between threads, and never in line, since it still
# searches for pairs. These arrays never leave their call, and those from outside are not counted.
_COUNT = """define internal void @NRT_{name}ref(ptr %array) alwaysinline nounwind {{
  %none = icmp eq ptr %array, null
  br i1 %none, label %end, label %some
some:
  %old = load i64, ptr %array
  %new = add i64 %old, {step}
  store i64 %new, ptr %array
  {rest}
end:
  ret void
}}
"""
_RELEASE = """%last = icmp eq i64 %new, 0
  br i1 %last, label %free, label %end
free:
  tail call void @NRT_MemInfo_call_dtor(ptr %array)
  br label %end"""


def tightened(bitcode: bytes, symbol: str, machine: Any) -> bytes:
    """Object code of the function ``symbol`` alone, made of all that numba has compiled for it.

    Everything else becomes private to it, so that what no call needs is dropped: most of the
    hundreds of numbers that named tuples put into each call, and the counting of references.
    The arithmetic is not touched. AttributeError with an LLVM that has no such passes.
    """
    llvm = _module('llvmlite.binding')
    text = str(llvm.parse_bitcode(bitcode))
    for name, step, rest in (('inc', 1, 'br label %end'), ('dec', -1, _RELEASE)):
        text = re.sub(rf'^define [^\n]*@NRT_{name}ref\(.*?^\}}\n',
                      _COUNT.format(name=name, step=step, rest=rest), text, flags=re.M | re.S)
    module = llvm.parse_assembly(text)
    for function in module.functions:
        if not function.is_declaration:
            function.linkage = 'external' if function.name == symbol else 'internal'
    module.verify()
    passes = llvm.create_new_module_pass_manager()
    for name in ('global_dead_code_eliminate', 'always_inliner', 'ipsccp',
                 'dead_arg_elimination', 'simplify_cfg', 'instruction_combine', 'simplify_cfg',
                 'global_dead_code_eliminate'):
        getattr(passes, f'add_{name}_pass')()
    passes.run(module, llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options()))
    module.verify()
    found: bytes = machine.emit_object(module)
    return found


def _object(codegen: Any, module: Any) -> bytes:
    text = _module('numba.core.cgutils').normalize_ir_text(str(module))
    made = _module('llvmlite.binding').parse_assembly(text)
    made.verify()
    found: bytes = codegen._tm.emit_object(made)
    return found


def _module(name: str) -> Any:
    """A module of the compiler: it is there only where the extra is installed."""
    return importlib.import_module(name)
