"""Runs command lines, nodes and Python expressions without any of the optional packages.

The process can import none of them.

The argument is a JSON object {"commands": [[word, ...], ...], "nodes": [module, ...],
"expressions": [text, ...]}; the output is one with exit code and lines on stderr of each command,
with what each node's module exits with, and with kind and message of the error of each expression.
"""

import contextlib
import io
import json
import runpy
import sys
from collections.abc import Sequence

from crane_sim.files import installation


class Absent:
    """A finder that finds the optional packages absent, as in an environment without them."""

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: object = None
    ) -> None:
        """Raise ModuleNotFoundError for an optional package's module, as for an absent one."""
        if name.partition(".")[0] in installation.PACKAGES:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


def run_command(words: list[str]) -> tuple[int, list[str]]:
    """Return exit code and lines on stderr of a command."""
    from crane_sim import cli

    sys.argv = ["crane", *words]
    with (
        contextlib.redirect_stderr(io.StringIO()) as errors,
        contextlib.redirect_stdout(io.StringIO()),
    ):
        code = cli.main()
    return code, errors.getvalue().splitlines()


def run_node(module: str) -> object:
    """Return what a node's module exits with: a line, which Python prints on stderr.

    Its exit code is then 1.
    """
    try:
        runpy.run_module(module, run_name="__main__")
    except SystemExit as end:
        return end.code
    return None


def evaluate(expression: str) -> tuple[str, str]:
    """Return kind and message of a Python expression's error; both empty without one."""
    import crane_sim

    try:
        eval(
            expression,
            {"crane_sim": crane_sim, "run": crane_sim.simulate("overhead_energy", duration=0.02)},
        )
    except Exception as error:
        return type(error).__name__, str(error)
    return "", ""


if __name__ == "__main__":
    wanted = json.loads(sys.argv[1])
    sys.meta_path.insert(0, Absent())
    installation.is_of_this_tree = lambda: False  # an environment that pip made
    commands = [run_command(words) for words in wanted["commands"]]
    nodes, expressions = map(run_node, wanted["nodes"]), map(evaluate, wanted["expressions"])
    print(
        json.dumps({"commands": commands, "nodes": list(nodes), "expressions": list(expressions)})
    )
