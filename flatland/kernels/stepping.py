"""LLVM assembly of many steps in a row, shared by several threads.

A hand-over between threads through the operating system costs about 60 µs here, as much as a
whole step at 128². So each thread runs all steps of a batch on its own rows, and they wait for
one another in a spinning barrier that yields the processor when the wait is long.
"""

from __future__ import annotations

#: Turns of the barrier's loop before each yield; about 20 µs.
_SPINS = 20_000

_TEMPLATE = """
define void @wait(ptr %counter, i64 %target, ptr %yield) {{
entry:
  %before = atomicrmw add ptr %counter, i64 1 seq_cst
  br label %spin
spin:
  %turn = phi i64 [0, %entry], [%next_turn, %again], [0, %give_way]
  %now = load atomic i64, ptr %counter seq_cst, align 8
  %ready = icmp sge i64 %now, %target
  br i1 %ready, label %end, label %count
count:
  %next_turn = add i64 %turn, 1
  %long = icmp sgt i64 %next_turn, {spins}
  br i1 %long, label %give_way, label %again
again:
  br label %spin
give_way:
  %ignored = call i32 %yield()
  br label %spin
end:
  ret void
}}

define void @steps(ptr %S, ptr %T, ptr %X, ptr %tau, i64 %first_row, i64 %last_row, ptr %box,
                   ptr %sums, i64 %count, ptr %cells, ptr %weights, i64 %first_cell, i64 %last_cell,
                   ptr %counter, i64 %parties, ptr %yield, ptr %mirror, ptr %rule) {{
entry:
  br label %step
step:
  %s = phi i64 [0, %entry], [%next_s, %step]
  %source = phi ptr [%S, %entry], [%target, %step]
  %target = phi ptr [%T, %entry], [%source, %step]
  %place = mul i64 %s, {sums}
  %here = getelementptr double, ptr %sums, i64 %place
  %left = call double @outflow(ptr %source, ptr %cells, ptr %weights, i64 %first_cell,
                               i64 %last_cell)
  %left_pointer = getelementptr double, ptr %here, i64 {last_sum}
  store double %left, ptr %left_pointer
  call void @sweep(ptr %source, ptr %target, ptr %X, ptr %tau, i64 %first_row, i64 %last_row,
                   ptr %box, ptr %here)
{images}  %next_s = add i64 %s, 1
  %goal = mul i64 %next_s, %parties
  call void @wait(ptr %counter, i64 %goal, ptr %yield)
  %more = icmp slt i64 %next_s, %count
  br i1 %more, label %step, label %end
end:
  ret void
}}
"""

_IMAGES = """\
  call void %mirror(ptr %target, ptr %rule, ptr %box, i64 %first_row, i64 %last_row, ptr %here)
"""


def stepping_text(sums: int, mirrors: bool = False) -> str:
    """Assembly of `steps`, to follow that of `sweep` and `outflow`.

    sums: numbers that a step reports: sums of components, sum of squares, flux that left. mirrors:
    each sweep is followed by a call for images, see `mirroring`.
    """
    images = _IMAGES if mirrors else ""
    return _TEMPLATE.format(spins=_SPINS, sums=sums, last_sum=sums - 1, images=images)
