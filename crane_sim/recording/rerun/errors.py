"""Error of a recording that cannot be written."""


class RecordingError(RuntimeError):
    """The recording could not be written; the message is one line."""
