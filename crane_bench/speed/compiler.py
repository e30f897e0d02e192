"""The C compiler of the benchmark's hand-written and generated loops; optional."""

import ctypes
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from crane_bench.speed.engine import EngineUnavailable

C_SOURCES = Path(__file__).with_name("floor")
"""Folder of the C files."""
NATIVE = ("-O3", "-march=native")


class Compiler:
    """A C compiler that puts libraries into a folder."""

    def __init__(self, folder: Path) -> None:
        """Find a compiler.

        Raises:
            EngineUnavailable: there is none.
        """
        program = next(filter(None, map(shutil.which, ("cc", "gcc", "clang"))), None)
        if program is None:
            raise EngineUnavailable("no C compiler found (cc, gcc, clang)")
        self.program, self.folder, self._count = program, folder, 0
        version_text = subprocess.run(
            [program, "--version"], capture_output=True, text=True, check=False
        ).stdout
        self.version = version_text.partition("\n")[0]

    def library(self, source: Path, flags: Sequence[str] = NATIVE) -> ctypes.CDLL:
        """Return the compiled and loaded library of one source file.

        Raises:
            EngineUnavailable: the compiler does not accept it.
        """
        self._count += 1
        target = self.folder / f"{source.stem}_{self._count}.so"
        include_paths = (f"-I{self.folder}", f"-I{C_SOURCES}")
        command = [
            self.program,
            *flags,
            "-shared",
            "-fPIC",
            *include_paths,
            str(source),
            "-lm",
            "-o",
            str(target),
        ]
        result = subprocess.run(command, capture_output=True, text=True, check=False)
        if result.returncode != 0:
            why = next(
                (line for line in result.stderr.splitlines() if "error" in line),
                "it does not say why",
            )
            raise EngineUnavailable(f"{self.program} does not compile {source.name}: {why}")
        return ctypes.CDLL(str(target))
