"""Memory of arrays that functions allocate: functions in LLVM's language, and their calls.

A list has all blocks that a call from outside has allocated, the last one first: each begins with
the address of the one before, and its size. `allocate` adds one; `sweep` frees those after the
block `mark` that hold none of some addresses, as a turn of a loop does; `release` frees all.
"""

from crane_sim.tracing.instructions import Block

MEMORY = """
declare ptr @malloc(i64)
declare void @free(ptr)

define internal ptr @allocate(ptr %list, i64 %size) nounwind noinline {
entry:
 %whole = add i64 %size, 64
 %block = call ptr @malloc(i64 %whole)
 %last = load ptr, ptr %list, align 8
 store ptr %last, ptr %block, align 8
 %place = getelementptr inbounds i8, ptr %block, i64 8
 store i64 %size, ptr %place, align 8
 store ptr %block, ptr %list, align 8
 %address = getelementptr inbounds i8, ptr %block, i64 64
 ret ptr %address
}

define internal void @sweep(ptr %list, ptr %mark, ptr %roots, i64 %count) nounwind noinline {
entry:
 br label %head
head:
 %link = phi ptr [%list, %entry], [%link, %drop], [%block, %kept]
 %block = load ptr, ptr %link, align 8
 %ends = icmp eq ptr %block, %mark
 br i1 %ends, label %end, label %body
body:
 %place = getelementptr inbounds i8, ptr %block, i64 8
 %size = load i64, ptr %place, align 8
 %first = getelementptr inbounds i8, ptr %block, i64 64
 %last = getelementptr inbounds i8, ptr %first, i64 %size
 br label %search
search:
 %i = phi i64 [0, %body], [%next, %other]
 %searches = icmp slt i64 %i, %count
 br i1 %searches, label %compare, label %drop
compare:
 %entry_of = getelementptr inbounds ptr, ptr %roots, i64 %i
 %root = load ptr, ptr %entry_of, align 8
 %behind = icmp uge ptr %root, %first
 %before = icmp ule ptr %root, %last
 %within = and i1 %behind, %before
 br i1 %within, label %kept, label %other
other:
 %next = add i64 %i, 1
 br label %search
kept:
 br label %head
drop:
 %rest = load ptr, ptr %block, align 8
 store ptr %rest, ptr %link, align 8
 call void @free(ptr %block)
 br label %head
end:
 ret void
}"""

RELEASE = """
define void @release(ptr %list) nounwind {
entry:
 %first = load ptr, ptr %list, align 8
 br label %head
head:
 %block = phi ptr [%first, %entry], [%next, %body]
 %ends = icmp eq ptr %block, null
 br i1 %ends, label %end, label %body
body:
 %next = load ptr, ptr %block, align 8
 call void @free(ptr %block)
 br label %head
end:
 store ptr null, ptr %list, align 8
 ret void
}"""


def allocates(block: Block) -> bool:
    """Return whether a block, or what it calls, may allocate memory."""
    for instruction in block.instructions:
        operation, literal = instruction.operation, instruction.literal
        if operation == "allocate" or (operation == "call" and literal.graph.has_allocations):
            return True
        if operation in ("branch", "loop") and any(map(allocates, literal)):
            return True
    return False
