"""Traced functions as machine code of this processor, by LLVM."""

from enum import Enum
from functools import cache
from typing import Any

import llvmlite.binding as llvm
from llvmlite import __version__ as LLVMLITE


class Optimisation(Enum):
    """Effort in making code fast, with the same bits: (level of passes, of code generation).

    Code that runs for some hundred instants costs more to optimise than it takes.
    """

    FULL = 2, 3
    LIGHT = 0, 1  # a third of the time; the code is slower by half
    NONE = 0, 0  # a sixth; slower by three times


LIGHT, NONE = Optimisation.LIGHT, Optimisation.NONE


class LoadedCode:
    """An object file in memory, alive as long as this object."""

    def __init__(self, object_file: bytes) -> None:
        """Load it."""
        self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _target_machine())
        self._engine.add_object_file(llvm.ObjectFileRef.from_data(object_file))
        self._engine.finalize_object()

    def address(self, name: str) -> int:
        """Return the address of a function that is called from outside."""
        return self._engine.get_function_address(name)


def compiler_name() -> tuple[str, str, str]:
    """Return the compiler and the processor that code is for."""
    return LLVMLITE, *_processor()


def compile_text(
    text: str, optimisation: Optimisation = Optimisation.FULL, loops: str = ""
) -> bytes:
    """Return the object file of a module's text.

    Args:
        text: of the module.
        optimisation: of its code.
        loops: the module of its functions with loops that are to become lanes.
    """
    passes, generation = optimisation.value
    machine, context = _target_machine(generation), llvm.create_context()  # what its end gives back
    module = _parse(text, machine, context)
    builder = llvm.create_pass_builder(machine, _tuning(passes))
    if loops:
        lanes = _parse(loops, machine, context)
        builder.getModulePassManager().run(lanes, builder)
        module.link_in(lanes)
    if passes:
        _hide_functions(module)
        _run_passes(module, builder)
    else:
        builder.getModulePassManager().run(module, builder)
    return machine.emit_object(module)


def _parse(text: str, machine: Any, context: Any) -> Any:
    module = llvm.parse_assembly(text, context)
    module.verify()
    module.triple, module.data_layout = machine.triple, str(machine.target_data)
    return module


def _hide_functions(module: Any) -> None:
    for function in module.functions:
        if not function.is_declaration and function.name not in _CALLED_FROM_OUTSIDE:
            function.linkage = "internal"


_CALLED_FROM_OUTSIDE = {"run", "release"}
_PASSES = (
    *(
        "always_inliner",
        "sroa",
        "instruction_combine",
        "simplify_cfg",
        "global_dead_code_eliminate",
    ),
    *("post_order_function_attributes", "dead_arg_elimination"),
)


def _run_passes(module: Any, builder: Any) -> None:
    """Run the passes for code without lanes, in a third of the time of LLVM's own sequence."""
    passes = llvm.create_new_module_pass_manager()
    for name in _PASSES:
        getattr(passes, f"add_{name}_pass")()
    passes.run(module, builder)
    of_functions = builder.getFunctionPassManager()
    for function in module.functions:
        if not function.is_declaration:
            of_functions.run(function, builder)


@cache
def _processor() -> tuple[str, str]:
    return llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()


def _target_machine(level: int = 3) -> Any:
    """Return a new one: an engine owns that which it was made with."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    cpu, features = _processor()
    target = llvm.Target.from_default_triple()
    return target.create_target_machine(cpu=cpu, features=features, opt=level, jit=True)


def _tuning(level: int) -> Any:
    options = llvm.create_pipeline_tuning_options(speed_level=level)
    # it takes as long as all other passes together, for a few per cent of speed
    options.slp_vectorization = False
    # lanes of the loops that ask for them
    options.loop_vectorization, options.loop_unrolling = True, False
    return options
