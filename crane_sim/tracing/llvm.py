"""Text of traced functions in LLVM's language."""

import itertools
from collections import Counter

from crane_sim.tracing.function import Function, callees, functions_with_callees
from crane_sim.tracing.llvm_control import FunctionText, Places, declaration, result_definition
from crane_sim.tracing.llvm_types import declarations
from crane_sim.tracing.shared_arguments import shared_places


def module_text(entry: Function) -> str:
    """Return the module of a function and all that it calls."""
    return _module(functions_with_callees(entry), {entry.name}, [], shared_places(entry))


def module_texts(entry: Function) -> tuple[str, str]:
    """Return (the module of a function, that of its loops for lanes), which are linked.

    LLVM makes lanes in a sequence of passes that takes three times as long as those that other code
    needs.
    """
    with_lanes = [f for f in functions_with_callees(entry) if f.graph.simd_loops]
    loops = functions_with_callees(*with_lanes, follows=_is_with_loops)
    outer = [f for loop in loops for f in callees(loop.block) if not _is_with_loops(f)]
    rest = functions_with_callees(entry, *outer, follows=lambda f: not f.graph.simd_loops)
    rest = [f.without_lanes._replace(name=f.name) if f.without_lanes else f for f in rest]
    inner = [f for f in loops if f.graph.simd_loops]
    places = shared_places(entry)
    main = _module(rest, {entry.name, *(f.name for f in outer)}, inner, places)
    return main, _module(loops, {f.name for f in inner}, outer, places) if loops else ""


def _is_with_loops(function: Function) -> bool:
    """Return whether a function that one with lanes calls is part of their module."""
    return function.inlined or bool(function.graph.simd_loops)


def _module(
    functions: list[Function], exported: set[str], outer: list[Function], places: Places
) -> str:
    """Return the module of functions, callees first; `outer` are those of another module."""
    nodes = itertools.count(1)  # of metadata
    inlined = _inlined_names(functions, exported)
    passed = {name: {} if name in inlined else known for name, known in places.items()}
    others = {f.name: f for f in outer}
    texts = [
        FunctionText(f, f.name in exported, f.name in inlined, passed, nodes).text
        for f in functions
    ]
    heads = [declaration(f, passed) for f in others.values()]
    types = [
        result_definition(f) for f in (*others.values(), *functions) if len(f.block.results) > 1
    ]
    return "\n".join((*declarations(), *types, *heads, *texts, "!0 = !{}", ""))


def _inlined_names(functions: list[Function], exported: set[str]) -> set[str]:
    """Return the inlined functions: those marked, and those called at one place after that."""
    calls, names = Counter[str](), set[str]()
    for function in reversed(functions):
        copies = 1
        if function.name not in exported and (function.inlined or calls[function.name] == 1):
            names.add(function.name)
            copies = calls[function.name]
        for callee in callees(function.block):
            calls[callee.name] += copies
    return names
