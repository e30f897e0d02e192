"""The error of what is not traced."""

_PLACES = 3  # that an error names


class TraceError(TypeError):
    """A traced function did what is not traced, such as with a symbol what only a number can do."""

    def __init__(self, message: str) -> None:
        super().__init__(message)
        self._message, self._places = message, list[str]()
        self._call: object = None

    def add_place(self, place: str, call: object) -> None:
        """Say where it happened: once for each call, from the innermost one on."""
        if call is not self._call and place not in self._places:
            self._places.append(place)
        self._call = call

    def __str__(self) -> str:
        """Return the message, and the innermost places."""
        places = ", called by ".join(self._places[:_PLACES])
        return f"{self._message}, in {places}" if places else self._message
