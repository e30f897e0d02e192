"""The C compiler, for what the benchmark compares with: it is found, not required."""

import ctypes
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from crane_sim.evaluation.bench.engine import Missing

FLOOR = Path(__file__).with_name("floor")
"""Where the C files are."""
NATIVE = ("-O3", "-march=native")


class Compiler:
    """A C compiler that puts libraries into a folder."""

    def __init__(self, folder: Path) -> None:
        """Find it.

        Raises:
            Missing: there is none.
        """
        found = next(filter(None, map(shutil.which, ("cc", "gcc", "clang"))), None)
        if found is None:
            raise Missing("no C compiler found (cc, gcc, clang)")
        self.program, self.folder, self._count = found, folder, 0
        said = subprocess.run([found, "--version"], capture_output=True, text=True, check=False).stdout
        self.version = said.partition("\n")[0]

    def library(self, source: Path, flags: Sequence[str] = NATIVE) -> ctypes.CDLL:
        """Return the compiled and loaded library of one source file.

        Raises:
            Missing: the compiler does not accept it.
        """
        self._count += 1
        target = self.folder / f"{source.stem}_{self._count}.so"
        places = (f"-I{self.folder}", f"-I{FLOOR}")
        command = [self.program, *flags, "-shared", "-fPIC", *places, str(source), "-lm", "-o", str(target)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            why = next((line for line in done.stderr.splitlines() if "error" in line), "it does not say why")
            raise Missing(f"{self.program} does not compile {source.name}: {why}")
        return ctypes.CDLL(str(target))
