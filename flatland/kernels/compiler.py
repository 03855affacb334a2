"""LLVM assembly to machine code."""

from __future__ import annotations

import ctypes
import threading
from collections import OrderedDict
from collections.abc import Callable
from functools import cache
from typing import Any

import llvmlite.binding as llvm

_POINTER, _INTEGER = ctypes.c_void_p, ctypes.c_int64
_SIGNATURES: dict[str, list[type[Any]]] = {
    "sweep": [_POINTER] * 4 + [_INTEGER] * 2 + [_POINTER] * 2,
    "steps": [_POINTER] * 4
    + [_INTEGER] * 2
    + [_POINTER] * 2
    + [_INTEGER]
    + [_POINTER] * 2
    + [_INTEGER] * 2
    + [_POINTER, _INTEGER]
    + [_POINTER] * 3,
    "multiply": [_POINTER, _INTEGER],
}
#: Compiled texts kept in memory; the oldest go first.
_KEPT = 64
_compiled: OrderedDict[str, CompiledText] = OrderedDict()
_lock = threading.Lock()


class CompiledText:
    """Machine code of one text; owns the memory that holds it.

    Calls release Python's lock, so several threads may share the rows of one grid.
    """

    def __init__(self, text: str) -> None:
        module = llvm.parse_assembly(text)
        module.verify()
        self._engine = llvm.create_mcjit_compiler(module, _target_machine())
        self._engine.finalize_object()

    def function(self, name: str) -> Callable[..., None]:
        """A function of the text; keep this object alive as long as it is used."""
        prototype = ctypes.CFUNCTYPE(None, *_SIGNATURES[name])
        function: Callable[..., None] = prototype(self._engine.get_function_address(name))
        return function


def compile_text(text: str) -> CompiledText:
    """The machine code of an assembly text, from memory if it was compiled before."""
    with _lock:
        if text in _compiled:
            _compiled.move_to_end(text)
            return _compiled[text]
        compiled = CompiledText(text)
        _compiled[text] = compiled
        if len(_compiled) > _KEPT:
            _compiled.popitem(last=False)
        return compiled


def _target_machine() -> llvm.TargetMachine:
    """A machine description for one engine, which owns and frees it."""
    _initialize()
    return llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(),
        features=llvm.get_host_cpu_features().flatten(),
        opt=3,
        codemodel="jitdefault",
    )


@cache
def _initialize() -> None:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
