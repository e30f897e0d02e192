"""Interpreter of Python functions that are called with symbols: what does not depend on numbers happens while tracing.

A function of plain Python runs statement by statement. Types, optional parts and loops of known length are resolved;
arithmetic on symbols notes instructions; a condition that is a symbol becomes a branch or a loop, whose variables are
those that it assigns. So one source is the code that is compiled and, called with floats, its own interpreter.
"""

import ast
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from crane_sim.tracing import arithmetic, array_symbols
from crane_sim.tracing.array_symbols import ArraySymbol, RecordSymbol
from crane_sim.tracing.graph import Block, Graph, Kind, TraceError, Value, numbers_of
from crane_sim.tracing.merging import (
    UNDEFINED,
    KindChange,
    Merge,
    Rebuild,
    fit,
    leaf_value,
    split,
)
from crane_sim.tracing.scopes import Source, assigned_names, has_exit, names_read_later

if TYPE_CHECKING:
    from crane_sim.tracing.calls import Calls

UNROLLED = 16
"""Turns of a loop of known length up to which it is unrolled."""
RUNS, BREAKS, RETURNS, CONTINUES = range(4)
"""What a turn of a loop ends with, as a number."""

_BINARY = {
    ast.Add: "add",
    ast.Sub: "subtract",
    ast.Mult: "multiply",
    ast.Div: "divide",
    ast.FloorDiv: "floor_divide",
    ast.Mod: "modulo",
    ast.Pow: "power",
    ast.BitAnd: "both",
    ast.BitOr: "either",
    ast.BitXor: "differ",
    ast.RShift: "shift_right",
    ast.LShift: "shift_left",
}
_COMPARE = {
    ast.Lt: "less",
    ast.LtE: "less_equal",
    ast.Gt: "greater",
    ast.GtE: "greater_equal",
    ast.Eq: "equal",
    ast.NotEq: "unequal",
}


class Returned:
    """The end of a function, with what it returns."""

    def __init__(self, value: Any) -> None:
        self.value = value


class _Bind(ast.stmt):
    """A statement that assigns a value that is known while tracing."""

    def __init__(self, target: ast.expr, value: Any) -> None:
        super().__init__()
        self.target, self.value = target, value


class Frame:
    """One call of a function: its variables, and where results of returns inside loops are kept."""

    def __init__(self, graph: Graph, calls: "Calls", source: Source, variables: dict[str, Any]) -> None:
        """Begin with the parameters as variables."""
        self.graph, self.calls, self.source, self.variables = graph, calls, source, variables
        self.depth = 0  # of loops that are traced
        self.result: tuple[Rebuild, list[Kind], Value, Any] | None = None
        self.result_kinds: list[Kind] = []

    # statements

    def run(self, statements: list[ast.stmt]) -> Any:
        """Run statements. Returns None, a `Returned`, or, inside a loop, how the turn ends: a number or a symbol."""
        for at, statement in enumerate(statements):
            rest = statements[at + 1 :]
            match statement:
                case ast.If():
                    done, outcome = self._run_if(statement, rest)
                case ast.For() | ast.While():
                    done, outcome = self._run_loop(statement, rest)
                case _:
                    outcome = self._run_simple(statement)
                    done = outcome is not None
            if done:
                return outcome
        return None

    def _run_simple(self, statement: ast.stmt) -> Any:
        match statement:
            case ast.Return(value=value):
                return self._leave(self.evaluate(value) if value else None)
            case ast.Assign(targets=targets, value=value):
                result = self.evaluate(value)
                for target in targets:
                    self.assign(target, result)
            case ast.AugAssign(target=target, op=op, value=value):
                before = self.evaluate(_as_load(target))
                self.assign(target, self._combine(_BINARY[type(op)], before, self.evaluate(value)))
            case ast.AnnAssign(target=target, value=value):
                if value is not None:
                    self.assign(target, self.evaluate(value))
            case ast.Expr(value=value):
                if not isinstance(value, ast.Constant):
                    self.evaluate(value)
            case _Bind():
                self.assign(statement.target, statement.value)
            case ast.Break():
                return BREAKS
            case ast.Continue():
                return CONTINUES
            case ast.Pass():
                pass
            case ast.Raise(exc=error):
                raise TraceError(f"{self.source.name} raises {ast.unparse(error) if error else ''}")
            case _:
                raise TraceError(f"{self.source.place(statement)}: {type(statement).__name__} is not traced")
        return None

    def _leave(self, value: Any) -> Any:
        """Return the outcome of a return statement; inside a loop what it returns is stored."""
        if not self.depth:
            return Returned(value)
        graph = self.graph
        if self.result is None:
            leaves, rebuild = split(value, graph, True)
            kinds = [leaf.kind for leaf in leaves]
            kinds = (
                [max(a, b, key=_rank) for a, b in zip(kinds, self.result_kinds, strict=True)]
                if self.result_kinds
                else kinds
            )
            self.result_kinds = kinds
            self.result = rebuild, kinds, graph.new_slot(len(leaves)), value
        _, kinds, slot, like = self.result
        try:
            leaves = fit(value, like, graph, iter(kinds), [0])
        except KindChange as change:
            self.result_kinds[change.index] = change.kind
            raise ResultChange from change
        for i, leaf in enumerate(leaves):
            graph.append("write", (leaf.number, slot.number), (), (8 * i, _CODES[leaf.kind]))
        return RETURNS

    def _stored_result(self) -> Any:
        assert self.result is not None
        rebuild, kinds, slot, _ = self.result
        leaves = [
            self.graph.append("read", (slot.number,), (kind,), (8 * i, _CODES[kind]))[0] for i, kind in enumerate(kinds)
        ]
        return rebuild(iter(leaves))

    def _run_if(self, statement: ast.If, rest: list[ast.stmt]) -> tuple[bool, Any]:
        condition = arithmetic.holds(self.evaluate(statement.test))
        if not isinstance(condition, Value):
            outcome = self.run([*(statement.body if condition else statement.orelse), *rest])
            return True, outcome
        if not has_exit(statement):
            self._branch(condition, lambda: self.run(statement.body), lambda: self.run(statement.orelse))
            return False, None
        if not self.depth:
            return True, self._branch(
                condition,
                lambda: self._value_of(statement.body + rest),
                lambda: self._value_of(statement.orelse + rest),
                True,
            )
        code = self._branch(
            condition, lambda: self._code_of(statement.body), lambda: self._code_of(statement.orelse), True
        ).value
        return True, self._go_on(code, rest)

    def _value_of(self, statements: list[ast.stmt]) -> Any:
        outcome = self.run(statements)
        return outcome.value if isinstance(outcome, Returned) else None

    def _code_of(self, statements: list[ast.stmt]) -> Any:
        outcome = self.run(statements)
        return RUNS if outcome is None else outcome

    def _go_on(self, code: Any, rest: list[ast.stmt]) -> Any:
        """Run what follows in the turn of a loop unless it has ended; return how it ends."""
        if not isinstance(code, Value):
            return self._code_of(rest) if code == RUNS else code
        if not rest:
            return code
        runs = arithmetic.combine("equal", code, RUNS)
        return self._branch(runs, lambda: self._code_of(rest), lambda: code, True).value

    def _branch(
        self, condition: Value, then: Callable[[], Any], otherwise: Callable[[], Any], wants: bool = False
    ) -> Any:
        """Record both sides; the variables become what the side that runs has made of them."""
        graph, before, sides = self.graph, self.variables, []
        for function in (then, otherwise):
            block, self.variables = graph.new_block(), dict(before)
            with graph.recording(block):
                result = function()
            sides.append((block, self.variables, result))
        (first, ours, a), (second, theirs, b) = sides
        merge, rebuilds = Merge(), {}
        for name in {**ours, **theirs}:
            mine, other = ours.get(name, UNDEFINED), theirs.get(name, UNDEFINED)
            count = len(merge.pairs)
            try:
                rebuilds[name] = merge.join(mine, other)
            except TraceError:
                del merge.pairs[count:]
                rebuilds[name] = lambda it: UNDEFINED  # an error where it is read
        value = merge.join(a, b) if wants else None
        results = self._close(merge, condition, first, second)
        it = iter(results)
        self.variables = {name: rebuild(it) for name, rebuild in rebuilds.items()}
        return Returned(value(it)) if value else None

    def _close(self, merge: Merge, condition: Value, first: Any, second: Any) -> list[Value]:
        graph, kinds = self.graph, tuple(kind for *_, kind in merge.pairs)
        blocks = []
        for side, block in enumerate((first, second)):
            with graph.recording(block):
                leaves = tuple(leaf_value(graph, pair[side], pair[2]) for pair in merge.pairs)
            blocks.append(Block(block.instructions, (), numbers_of(leaves)))
        if not kinds and not any(block.instructions for block in blocks):
            return []
        return list(graph.append("branch", (condition.number,), kinds, tuple(blocks)))

    # loops

    def _run_loop(self, loop: ast.For | ast.While, rest: list[ast.stmt]) -> tuple[bool, Any]:
        if isinstance(loop, ast.For):
            turns = self._known_turns(loop)
            if turns is not None:
                statements: list[ast.stmt] = []
                for value in turns:
                    statements += [_Bind(loop.target, value), *loop.body]
                return True, self.run(statements + rest)
        code = self._trace_loop(loop)
        if code is None:
            return False, None
        if self.depth:
            ends = arithmetic.choose(arithmetic.combine("equal", code, RETURNS), RETURNS, RUNS)
            return True, self._go_on(ends, rest)
        if self.result is None:
            return False, None
        if isinstance(loop, ast.While) and isinstance(loop.test, ast.Constant) and not _breaks(loop):
            return True, Returned(self._stored_result())  # nothing else ends it
        returns = arithmetic.combine("equal", code, RETURNS)
        outcome = self._branch(returns, self._stored_result, lambda: self._value_of(rest), True)
        return True, outcome

    def _known_turns(self, loop: ast.For) -> list[Any] | None:
        """Return what the variable of a loop is in its turns, None where that depends on numbers."""
        iterable = self._evaluate_iterable(loop.iter)
        self._iterable = iterable
        if isinstance(iterable, tuple | list):
            return list(iterable)
        if isinstance(iterable, range) and len(iterable) <= UNROLLED and not _breaks(loop):
            return list(iterable)
        return None

    def _evaluate_iterable(self, node: ast.expr) -> Any:
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "range":
            bounds = [self.evaluate(x) for x in node.args]
            if not any(isinstance(x, Value) for x in bounds):
                return range(*bounds)
            return _Range(*bounds)
        return self.evaluate(node)

    def _trace_loop(self, loop: ast.For | ast.While) -> Any:
        """Record a loop; return how it ended, None for a loop that only ends by its condition."""
        steps = _as_range(self._iterable) if isinstance(loop, ast.For) else None
        names = [name for name in assigned_names(loop) if self.variables.get(name, UNDEFINED) is not UNDEFINED]
        extra: dict[str, Any] = {}
        promoted: dict[int, Kind] = {}
        while True:
            slots = self.result
            try:
                return self._record_loop(loop, steps, names, extra, promoted)
            except KindChange as change:
                promoted[change.index] = change.kind
                self.result = slots
            except _LateVariable as late:
                extra[late.name] = late.value
                names = [*names, late.name]
                self.result = slots

    def _record_loop(
        self, loop: ast.For | ast.While, steps: Any, names: list[str], extra: dict[str, Any], promoted: dict[int, Kind]
    ) -> Any:
        graph, before, exits = self.graph, self.variables, has_exit(loop)
        first = steps.first if steps else None
        state = (
            tuple(before[name] if name in before else extra[name] for name in names),
            first,
            RUNS if exits else None,
        )
        leaves, rebuild = split(state, graph, True)
        kinds = [promoted.get(i, leaf.kind) for i, leaf in enumerate(leaves)]
        leaves = [
            leaf if kind is Kind.ARRAY else arithmetic.convert(graph, leaf, kind)
            for leaf, kind in zip(leaves, kinds, strict=True)
        ]
        self.depth += 1
        try:
            proceed = self._record_turn(
                rebuild, kinds, names, lambda index, code: self._proceeds(loop, steps, index, code)
            )
            body = self._record_turn(
                rebuild, kinds, names, lambda index, code: self._turn(loop, steps, index, exits, names, state, kinds)
            )
        finally:
            self.depth -= 1
            self.variables = before
        results = graph.append("loop", numbers_of(tuple(leaves)), tuple(kinds), (proceed, body))
        if isinstance(steps, SimdRange):
            graph.simd_loops.add(results[0].number)
        after, _, code = rebuild(iter(results))
        self.variables = {**before, **dict(zip(names, after, strict=True))}
        for name in assigned_names(loop):
            if name not in names:
                self.variables[name] = UNDEFINED
        return code

    def _record_turn(
        self, rebuild: Rebuild, kinds: list[Kind], names: list[str], function: Callable[..., list[Value]]
    ) -> Block:
        graph, before = self.graph, self.variables
        block = graph.new_block()
        with graph.recording(block):
            parameters = tuple(graph.new_value(kind) for kind in kinds)
            values, index, code = rebuild(iter(parameters))
            self.variables = {**before, **dict(zip(names, values, strict=True))}
            results = function(index, code)
        self.variables = before
        return Block(block.instructions, numbers_of(parameters), numbers_of(tuple(results)))

    def _proceeds(self, loop: ast.For | ast.While, steps: Any, index: Any, code: Any) -> list[Value]:
        if steps:
            condition = arithmetic.combine("less" if steps.rises else "greater", index, steps.last)
        else:
            assert isinstance(loop, ast.While)
            condition = arithmetic.holds(self.evaluate(loop.test))
        if code is not None:
            condition = arithmetic.combine("both", condition, arithmetic.combine("equal", code, RUNS))
        return [arithmetic.convert(self.graph, condition, Kind.BOOLEAN)]

    def _turn(
        self, loop: Any, steps: Any, index: Any, exits: bool, names: list[str], state: Any, kinds: list[Kind]
    ) -> list[Value]:
        if steps:
            self.assign(loop.target, steps.value(index))
        code = self.run(loop.body)
        code = RUNS if code is None else code
        if isinstance(code, Value):
            code = arithmetic.choose(arithmetic.combine("equal", code, CONTINUES), RUNS, code)
        elif code == CONTINUES:
            code = RUNS
        if steps:
            index = arithmetic.combine("add", index, steps.step)
        for name in assigned_names(loop):
            value = self.variables.get(name, UNDEFINED)
            if name not in names and value is not UNDEFINED and name in names_read_later(self.source, loop):
                raise _LateVariable(name, _zeros_like(self.graph, value))
        values = tuple(self.variables[name] for name in names)
        return fit((values, index, code if exits else None), state, self.graph, iter(kinds), [0])

    # assignments

    def assign(self, target: ast.expr, value: Any) -> None:
        """Assign a value to a variable, an element, a field, or several of them."""
        match target:
            case ast.Name(id=name):
                self.variables[name] = value
            case ast.Tuple(elts=targets) | ast.List(elts=targets):
                self._unpack(targets, value)
            case ast.Subscript(value=owner, slice=index):
                array = self.evaluate(owner)
                if not isinstance(array, ArraySymbol):
                    raise TraceError(f"{self.source.place(target)}: only elements of arrays are assigned")
                array_symbols.set_item(array, self._index(index), value)
            case ast.Attribute(value=owner, attr=name):
                record = self.evaluate(owner)
                if isinstance(record, ArraySymbol):
                    array_symbols.assign(array_symbols.get_field(record, name), value)
                else:
                    array_symbols.set_field(record, name, value)
            case _:
                raise TraceError(f"{self.source.place(target)}: such a target is not traced")

    def _unpack(self, targets: list[ast.expr], value: Any) -> None:
        if isinstance(value, ArraySymbol):
            value = tuple(array_symbols.get_item(value, i) for i in range(len(targets)))
        values = list(value)
        star = next((i for i, target in enumerate(targets) if isinstance(target, ast.Starred)), None)
        if star is not None:
            after = len(targets) - star - 1
            end = len(values) - after
            values = [*values[:star], tuple(values[star:end]), *values[end:]]
        if len(values) != len(targets):
            raise TraceError(f"{self.source.place(targets[0])}: {len(values)} values for {len(targets)} variables")
        for target, x in zip(targets, values, strict=True):
            self.assign(target.value if isinstance(target, ast.Starred) else target, x)

    # expressions

    def evaluate(self, node: ast.expr) -> Any:
        """Return the value of an expression."""
        return _EVALUATORS[type(node)](self, node)

    def _constant(self, node: ast.Constant) -> Any:
        return node.value

    def _name(self, node: ast.Name) -> Any:
        name = node.id
        if name in self.variables:
            value = self.variables[name]
            if value is UNDEFINED:
                raise TraceError(f"{self.source.place(node)}: {name} may have no value, or values of two kinds")
            return value
        return self.source.look_up(name)

    def _binary(self, node: ast.BinOp) -> Any:
        return self._combine(_BINARY[type(node.op)], self.evaluate(node.left), self.evaluate(node.right))

    def _combine(self, operation: str, a: Any, b: Any) -> Any:
        if isinstance(a, ArraySymbol) or isinstance(b, ArraySymbol):
            return array_symbols.elementwise(lambda x, y: arithmetic.combine(operation, x, y), a, b)
        return arithmetic.combine(operation, a, b)

    def _unary(self, node: ast.UnaryOp) -> Any:
        x = self.evaluate(node.operand)
        match node.op:
            case ast.USub():
                return (
                    array_symbols.elementwise(arithmetic.negate, x)
                    if isinstance(x, ArraySymbol)
                    else arithmetic.negate(x)
                )
            case ast.Not():
                return arithmetic.invert(x)
            case ast.UAdd():
                return x
            case _:
                return arithmetic.combine("differ", x, -1)

    def _compare(self, node: ast.Compare) -> Any:
        left, result = self.evaluate(node.left), True
        for op, comparator in zip(node.ops, node.comparators, strict=True):
            right = self.evaluate(comparator)
            part = self._compare_two(op, left, right)
            result = part if result is True else arithmetic.combine("both", result, part)
            if result is False:
                return False
            left = right
        return result

    def _compare_two(self, op: ast.cmpop, left: Any, right: Any) -> Any:
        match op:
            case ast.Is():
                return left is right
            case ast.IsNot():
                return left is not right
            case ast.In():
                return left in right
            case ast.NotIn():
                return left not in right
            case _:
                if isinstance(left, Value) or isinstance(right, Value):
                    return arithmetic.combine(_COMPARE[type(op)], left, right)
                return arithmetic.combine(_COMPARE[type(op)], left, right)

    def _both(self, node: ast.BoolOp) -> Any:
        return self._logical(node.values, isinstance(node.op, ast.And))

    def _logical(self, parts: list[ast.expr], conjunction: bool) -> Any:
        value = self.evaluate(parts[0])
        if len(parts) == 1:
            return value
        condition = arithmetic.holds(value) if isinstance(value, Value) else bool(value)
        if not isinstance(condition, Value):
            return self._logical(parts[1:], conjunction) if condition == conjunction else value

        def following() -> Any:
            return arithmetic.holds(self._logical(parts[1:], conjunction))

        sides = (following, lambda: False) if conjunction else (lambda: True, following)
        return self._branch(condition, *sides, True).value

    def _conditional(self, node: ast.IfExp) -> Any:
        condition = arithmetic.holds(self.evaluate(node.test))
        if not isinstance(condition, Value):
            return self.evaluate(node.body if condition else node.orelse)
        return self._branch(condition, lambda: self.evaluate(node.body), lambda: self.evaluate(node.orelse), True).value

    def _tuple(self, node: ast.Tuple | ast.List) -> Any:
        values: list[Any] = []
        for element in node.elts:
            if isinstance(element, ast.Starred):
                values += self._items(self.evaluate(element.value))
            else:
                values.append(self.evaluate(element))
        return tuple(values)

    def _items(self, value: Any) -> list[Any]:
        if isinstance(value, ArraySymbol):
            if isinstance(value.shape[0], Value):
                raise TraceError("the length of an array that is unpacked is not known")
            return [array_symbols.get_item(value, i) for i in range(value.shape[0])]
        return list(value)

    def _subscript(self, node: ast.Subscript) -> Any:
        owner, index = self.evaluate(node.value), self._index(node.slice)
        if isinstance(owner, ArraySymbol):
            return array_symbols.get_item(owner, index)
        if isinstance(owner, RecordSymbol):
            return array_symbols.get_field(owner, index)
        if isinstance(index, Value):
            return self._select_item(owner, index)
        if _is_array(owner):
            return self.calls.constant_array(self.graph, owner, index)
        return owner[index]

    def _select_item(self, items: Any, index: Value) -> Any:
        """Return an element of a tuple at a place that is known only when the code runs."""
        if _is_array(items):
            return array_symbols.get_item(self.calls.array_of(self.graph, items), index)
        result = items[-1]
        for i in range(len(items) - 2, -1, -1):
            at = arithmetic.combine("equal", index, i)
            result = _choose_tree(at, items[i], result)
        return result

    def _index(self, node: ast.expr) -> Any:
        if isinstance(node, ast.Slice):
            parts = (node.lower, node.upper, node.step)
            return slice(*(self.evaluate(part) if part else None for part in parts))
        if isinstance(node, ast.Tuple):
            return tuple(self._index(part) for part in node.elts)
        return self.evaluate(node)

    def _attribute(self, node: ast.Attribute) -> Any:
        owner = self.evaluate(node.value)
        if isinstance(owner, ArraySymbol):
            return self._array_attribute(owner, node.attr)
        if isinstance(owner, RecordSymbol):
            return array_symbols.get_field(owner, node.attr)
        return getattr(owner, node.attr)

    def _array_attribute(self, array: ArraySymbol, name: str) -> Any:
        if array.dtype.names and name in array.dtype.names:
            return array_symbols.get_field(array, name)
        match name:
            case "shape" | "dtype" | "strides":
                return getattr(array, name)
            case "T":
                return replace(array, shape=array.shape[::-1], strides=array.strides[::-1])
            case "copy":
                return lambda: array_symbols.copy_of(array)
            case "min" | "max":
                return lambda: array_symbols.extreme(array, name)
            case "sum":
                return lambda: array_symbols.total(array)
            case "size":
                return _product(array.shape)
            case "ndim":
                return len(array.shape)
            case _:
                raise TraceError(f"{self.source.name}: {name} of an array is not traced")

    def _call(self, node: ast.Call) -> Any:
        function = self.evaluate(node.func)
        arguments: list[Any] = []
        for argument in node.args:
            if isinstance(argument, ast.Starred):
                arguments += self._items(self.evaluate(argument.value))
            else:
                arguments.append(self.evaluate(argument))
        keywords = {k.arg: self.evaluate(k.value) for k in node.keywords if k.arg}
        for k in node.keywords:
            if k.arg is None:
                keywords |= self.evaluate(k.value)
        try:
            return self.calls.call(self.graph, function, arguments, keywords)
        except TraceError as error:
            raise TraceError(f"{error}\n  in {self.source.place(node)}") if len(str(error)) < 3000 else error

    def _comprehension(self, node: ast.ListComp | ast.GeneratorExp) -> Any:
        results: list[Any] = []

        def turn(generators: list[ast.comprehension]) -> None:
            if not generators:
                results.append(self.evaluate(node.elt))
                return
            iterable = self._evaluate_iterable(generators[0].iter)
            for value in self._items(iterable):
                self.assign(generators[0].target, value)
                if all(self.evaluate(test) for test in generators[0].ifs):
                    turn(generators[1:])

        before = self.variables
        self.variables = dict(before)
        turn(node.generators)
        self.variables = before
        return results

    def _format(self, node: ast.JoinedStr) -> Any:
        return "".join(str(self.evaluate(part)) for part in node.values)

    def _formatted(self, node: ast.FormattedValue) -> Any:
        return format(self.evaluate(node.value), "")

    def _dict(self, node: ast.Dict) -> Any:
        return {self.evaluate(k): self.evaluate(v) for k, v in zip(node.keys, node.values, strict=True) if k}


class ResultChange(TraceError):
    """What a function returns needs other kinds of numbers: it is traced again."""


class _LateVariable(Exception):
    """A variable that a loop assigns first is read behind the loop: it needs a value before it."""

    def __init__(self, name: str, value: Any) -> None:
        super().__init__(name)
        self.name, self.value = name, value


class _Range:
    """The numbers of a range of which a bound is a symbol."""

    def __init__(self, *bounds: Any) -> None:
        self.first, self.last, self.step = (0, bounds[0], 1) if len(bounds) == 1 else (*bounds, 1)[:3]
        self.rises = isinstance(self.step, Value) or self.step > 0  # a step that is a symbol is a positive one

    def value(self, index: Any) -> Any:
        """Return what the loop's variable is at an index."""
        return index


class SimdRange(_Range):
    """The numbers of a `simd_range`."""


class _Elements(_Range):
    """The elements of an array."""

    def __init__(self, array: ArraySymbol) -> None:
        super().__init__(array.shape[0])
        self.array = array

    def value(self, index: Any) -> Any:
        """Return the element at an index."""
        return array_symbols.get_item(self.array, index)


def _as_range(iterable: Any) -> _Range:
    if isinstance(iterable, ArraySymbol):
        return _Elements(iterable)
    if isinstance(iterable, range):
        return _Range(iterable.start, iterable.stop, iterable.step)
    if isinstance(iterable, _Range):
        return iterable
    raise TraceError(f"a loop over {type(iterable).__name__} is not traced")


def _zeros_like(graph: Graph, tree: Any) -> Any:
    """Return a tree of zeros of the same kinds, as constants outside of a loop."""
    if isinstance(tree, tuple):
        parts = [_zeros_like(graph, part) for part in tree]
        return type(tree)(*parts) if hasattr(tree, "_fields") else tuple(parts)
    if isinstance(tree, Value):
        return {Kind.REAL: 0.0, Kind.BOOLEAN: False}.get(tree.kind, 0)
    if isinstance(tree, ArraySymbol | RecordSymbol):
        raise TraceError("an array that a loop makes is used behind it")
    return tree


def _choose_tree(condition: Value, a: Any, b: Any) -> Any:
    if isinstance(a, tuple):
        parts = [_choose_tree(condition, x, y) for x, y in zip(a, b, strict=True)]
        return type(a)(*parts) if hasattr(a, "_fields") else tuple(parts)
    return arithmetic.choose(condition, a, b)


def _product(sizes: tuple[Any, ...]) -> Any:
    result: Any = 1
    for size in sizes:
        result = arithmetic.combine("multiply", result, size)
    return result


def _is_array(x: Any) -> bool:
    return type(x).__module__ == "numpy" and type(x).__name__ in ("ndarray", "recarray")


def _breaks(loop: ast.For | ast.While) -> bool:
    return any(isinstance(node, ast.Break | ast.Continue) for node in ast.walk(loop))


def _as_load(target: ast.expr) -> ast.expr:
    """Return a target of an assignment as an expression that reads it: the evaluators do not look at contexts."""
    return target


def _rank(kind: Kind) -> int:
    return [Kind.ARRAY, Kind.BOOLEAN, Kind.INTEGER, Kind.WORD, Kind.REAL].index(kind)


_CODES = {Kind.REAL: "f8", Kind.INTEGER: "i8", Kind.WORD: "u8", Kind.BOOLEAN: "b1", Kind.ARRAY: "p8"}
_EVALUATORS: dict[type, Callable[[Frame, Any], Any]] = {
    ast.Constant: Frame._constant,
    ast.Name: Frame._name,
    ast.BinOp: Frame._binary,
    ast.UnaryOp: Frame._unary,
    ast.Compare: Frame._compare,
    ast.BoolOp: Frame._both,
    ast.IfExp: Frame._conditional,
    ast.Tuple: Frame._tuple,
    ast.List: Frame._tuple,
    ast.Subscript: Frame._subscript,
    ast.Attribute: Frame._attribute,
    ast.Call: Frame._call,
    ast.ListComp: Frame._comprehension,
    ast.GeneratorExp: Frame._comprehension,
    ast.JoinedStr: Frame._format,
    ast.FormattedValue: Frame._formatted,
    ast.Dict: Frame._dict,
}
