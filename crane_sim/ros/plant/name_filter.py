"""Filters of names: POSIX extended regular expressions, as simulation_interfaces requires, by the C library.

Python's `re` has another syntax, and may take exponential time. Intervals {m,n}, back-references and many + are
refused: the C library repeats what they apply to, and a short expression, such as (((a+)+)+)+, can take all memory;
(((a|b|…)+)+)+ takes a time that grows with the third power of the number of alternatives.
"""

import ctypes
import re

_LONGEST = 100  # characters of an expression
_MOST_PLUS = 2  # with as many alternatives as have room half a second
_EXTENDED, _NO_POSITIONS = 1, 8  # flags of regcomp in glibc and musl: REG_EXTENDED, REG_NOSUB
_SIZE = 1024  # bytes, more than a regex_t of any C library has
_COSTLY = re.compile(r"\{|\\[0-9]")


class NameFilter:
    """A compiled expression; one that is empty matches every name."""

    def __init__(self, expression: str) -> None:
        """Compile it.

        Raises:
            ValueError: it is not a valid expression, or too costly; the message is one line.
        """
        if len(expression) > _LONGEST or expression.count("+") > _MOST_PLUS or _COSTLY.search(expression):
            most = f"more than {_MOST_PLUS} + and more than {_LONGEST} characters"
            raise ValueError(f"filter: intervals, references back, {most} are not possible")
        self._library, self._compiled = ctypes.CDLL(None), ctypes.create_string_buffer(_SIZE)
        code = self._library.regcomp(self._compiled, expression.encode(), _EXTENDED | _NO_POSITIONS)
        if code:
            line = ctypes.create_string_buffer(100)
            self._library.regerror(code, self._compiled, line, len(line))
            raise ValueError(f"filter = {expression!r}: {line.value.decode()}")

    def matches(self, name: str) -> bool:
        """Return whether a part of the name matches; ^ and $ are its ends."""
        return self._library.regexec(self._compiled, name.encode(), 0, None, 0) == 0

    def close(self) -> None:
        """Release the memory of the C library."""
        self._library.regfree(self._compiled)
