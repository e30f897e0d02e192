"""Arguments of an entry point that its callees read themselves, instead of being passed them.

A crane's masses and lengths go unchanged through many calls, some hundred numbers each. What every
call of a function passes from the same place of the entry point's memory is no parameter of its
code.
"""

from collections.abc import Iterator

from crane_sim.tracing.function import Function, functions_with_callees
from crane_sim.tracing.instructions import Block, Instruction

Place = tuple[int, str]
"""Where a number is in the entry point's memory [bytes], and its type there."""
Sources = dict[int, int]
"""Of values that are other ones unchanged: the first of these."""


def shared_places(entry: Function) -> dict[str, dict[int, Place]]:
    """Return, by function, its parameters that are always the same argument of the entry point."""
    functions, sources = functions_with_callees(entry), dict[str, Sources]()
    for function in functions:
        sources[function.name] = _sources_in(function.block, sources)
    found: dict[str, dict[int, Place]] = {entry.name: {}}
    for function in reversed(functions):
        places, source_of = (
            found[function.name] | _places_read(function, entry),
            sources[function.name],
        )
        for call in _calls_in(function.block):
            callee: Function = call.literal
            pairs = zip(callee.block.parameters, call.arguments, strict=True)
            firsts = [(parameter, _first(source_of, number)) for parameter, number in pairs]
            passed = {parameter: places[first] for parameter, first in firsts if first in places}
            before = found.get(callee.name, passed)
            found[callee.name] = {
                number: place for number, place in passed.items() if before.get(number) == place
            }
    return found


def _places_read(function: Function, entry: Function) -> dict[int, Place]:
    """Return what the entry point itself reads from its memory."""
    if function is not entry:
        return {}
    return {i.results[0]: i.literal for i in entry.block.instructions
            if i.operation == "read" and i.arguments == entry.block.parameters}  # fmt: skip


def _calls_in(block: Block) -> Iterator[Instruction]:
    for instruction in block.instructions:
        if instruction.operation == "call":
            yield instruction
        elif instruction.operation in ("branch", "loop"):
            for inner in instruction.literal:
                yield from _calls_in(inner)


def _first(sources: Sources, number: int) -> int:
    return sources.get(number, number)


def _sources_in(block: Block, known: dict[str, Sources]) -> Sources:
    """Return the sources of values of a block: what loops, branches and functions pass on."""
    sources: Sources = {}
    for instruction in block.instructions:
        if instruction.operation == "call":
            sources |= _passed_on(instruction, known[instruction.literal.name], sources)
        elif instruction.operation == "branch":
            then, otherwise = instruction.literal
            sources |= _sources_in(then, known) | _sources_in(otherwise, known)
            for result, a, b in zip(
                instruction.results, then.results, otherwise.results, strict=True
            ):
                if _first(sources, a) == _first(sources, b):
                    sources[result] = _first(sources, a)
        elif instruction.operation == "loop":
            sources |= _kept_by_loop(instruction, known, sources)
    return sources


def _passed_on(call: Instruction, inner: Sources, sources: Sources) -> Sources:
    callee: Function = call.literal
    arguments = dict(zip(callee.block.parameters, call.arguments, strict=True))
    firsts = [
        (result, _first(inner, number))
        for result, number in zip(call.results, callee.block.results, strict=True)
    ]
    return {
        result: _first(sources, arguments[first]) for result, first in firsts if first in arguments
    }


def _kept_by_loop(loop: Instruction, known: dict[str, Sources], sources: Sources) -> Sources:
    proceed, body = loop.literal
    inner = _sources_in(proceed, known) | _sources_in(body, known)
    states = zip(
        loop.results, loop.arguments, proceed.parameters, body.parameters, body.results, strict=True
    )
    for result, start, first, parameter, following in states:
        if _first(inner, following) == parameter:
            source = _first(sources, start)
            inner |= {result: source, first: source, parameter: source}
    return {number: _first(inner, source) for number, source in inner.items()}
