"""Machine code of entry points on disk, in a folder for each state of the sources.

What is read fits by construction: the folder is named after a digest of the packages' sources, the file after the
function, the structure of its arguments, the processor and the compiler; functions of other files, such as a law of the
user's, are named in the file with digests of theirs. A file that is damaged, or cannot be written, costs a compilation.
"""

import hashlib
import os
import pickle
from contextlib import suppress
from pathlib import Path
from typing import Any

from crane_sim.tracing.arguments import text_of
from crane_sim.tracing.cache import SOURCES_AT_IMPORT, cache_folder
from crane_sim.tracing.machine_code import compiler_name

_DIGEST = hashlib.sha256().digest_size


def read_entry(function: Any, key: Any) -> Any:
    """Return the code of a function for a structure of arguments, None where there is none that is whole and fits."""
    try:
        if not SOURCES_AT_IMPORT.is_current():
            return None
        content = _file(function, key).read_bytes()
        digest, data = content[:_DIGEST], content[_DIGEST:]
        if hashlib.sha256(data).digest() != digest:
            return None
        files, code = pickle.loads(data)
        return code if all(_digest_of(file) == known for file, known in files) else None
    except Exception:  # a file of code may hold anything: whatever it is, there is none
        return None


def write_entry(function: Any, key: Any, code: Any) -> None:
    """Keep code, where the folder can be written and the code can be read again."""
    with suppress(OSError, pickle.PicklingError, AttributeError, TypeError):
        if not SOURCES_AT_IMPORT.is_current():
            return
        others = [file for file in code.files if not SOURCES_AT_IMPORT.includes(file)]
        data = pickle.dumps(([(file, _digest_of(file)) for file in others], code))
        file = _file(function, key)
        part = file.with_suffix(f".{os.getpid()}")
        try:
            part.write_bytes(hashlib.sha256(data).digest() + data)
            part.replace(file)
        finally:
            part.unlink(missing_ok=True)


def _file(function: Any, key: Any) -> Path:
    name = function.__module__, function.__qualname__, function.__code__.co_filename, text_of(key), *compiler_name()
    return cache_folder() / f"{function.__name__}-{hashlib.sha256(repr(name).encode()).hexdigest()[:24]}.code"


def _digest_of(file: str) -> str:
    return hashlib.sha256(Path(file).read_bytes()).hexdigest()
