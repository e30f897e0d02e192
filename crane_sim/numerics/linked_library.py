"""Compilation of functions that only compiled code calls: their LLVM code is linked into what calls them."""

from typing import Any, Literal

from llvmlite.binding import Linkage
from numba._dynfunc import make_function
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import AnnotateTypes, NativeLowering


class LinkedLibrary(JITCodeLibrary):
    """Library of LLVM code that is linked into its callers, and not compiled to machine code by itself."""

    optimized = False
    source = ""  # the file of the function
    _final_module: Any
    _shared_module: Any

    def _optimize_final_module(self) -> None:
        """Optimise only code of which there are many copies; all else is optimised as part of the entry point."""
        if self.optimized:
            super()._optimize_final_module()

    def _get_module_for_linking(self) -> Any:
        self._ensure_finalized()
        if self._shared_module is None:
            for function in self._final_module.functions:
                if not function.is_declaration and function.linkage == Linkage.external:
                    function.linkage = "linkonce_odr"  # several callers link it in
            self._shared_module = self._final_module
        return self._shared_module

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)
class _LinkedLowering(NativeLowering):
    """Numba's lowering into a `LinkedLibrary`."""

    _name = "linked_lowering"
    _optimized = False

    def run_pass(self, state: Any) -> Literal[True]:
        """Lower the function, and register it under a key that stands for its address."""
        name = state.func_id.func_qualname
        state.library = LinkedLibrary(state.targetctx.codegen(), name)
        state.library.optimized, state.library.source = self._optimized, state.func_id.filename
        state.flags.no_compile = True
        super().run_pass(state)
        lowered = state.cr
        key = make_function(lowered.fndesc.lookup_module(), name, name, 0, lowered.env, (state.library,))
        state.targetctx.insert_user_function(key, lowered.fndesc, [state.library])
        state.reload_init.extend(state.library._reload_init)
        state.cr = lowered._replace(cfunc=key)
        return True


@register_pass(mutates_CFG=True, analysis_only=False)
class _OptimizedLowering(_LinkedLowering):
    _name = "optimized_lowering"
    _optimized = True


class LinkedCompiler(CompilerBase):
    """Numba's compiler for functions that only compiled code calls."""

    _lowering: type = _LinkedLowering

    def define_pipelines(self) -> list[Any]:
        """Return numba's passes with the lowering replaced."""
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        needed = [
            (step, why) for step, why in passes.passes if step is not AnnotateTypes
        ]  # it would keep the syntax tree in memory
        passes.passes[:] = [(self._lowering if step is NativeLowering else step, why) for step, why in needed]
        passes.finalize()
        return [passes]


class OptimizedCompiler(LinkedCompiler):
    """Numba's compiler for functions of which a caller holds many copies, such as the stages of a step."""

    _lowering = _OptimizedLowering


def linked_sources(library: Any) -> set[str]:
    """Return the files of all functions that are linked into a library, as where a module's function was replaced."""
    sources, seen, pending = set[str](), set[int](), [library]
    while pending:
        linked = pending.pop()
        if id(linked) not in seen:
            seen.add(id(linked))
            pending += linked._linking_libraries
            sources |= {linked.source} if isinstance(linked, LinkedLibrary) else set()
    return sources
