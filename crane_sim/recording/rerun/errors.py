"""Error of a recording that cannot be written."""


class RecordingError(RuntimeError):
    """The recording could not be written; the message is one line.

    Afterwards the Rerun library may wait for ever for its writer thread, even at interpreter exit: a process that gets
    this error ends with `os._exit`.
    """
