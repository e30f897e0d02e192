"""The page on the Python interface, from signatures, docstrings and comments on attributes."""

import ast
import inspect
import re
import textwrap
from collections.abc import Callable, Iterator
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import Any

import crane_sim
from crane_bench.documentation.fields import comments
from crane_sim.files.output import write_output

COMMAND = "crane describe --python --save docs"
HEAD = f"""# Python interface

Written by `{COMMAND}` from the source: what `import crane_sim` gives. Shapes are in
parentheses: nq joints, nu of them actuated, K instants. `help(crane_sim.simulate)` shows the same in an interpreter.
"""  # noqa: E501
RUNS = ("RecordedRun", "Rollout")
"""Classes of what examples call `run`."""
WIDEST = 110  # characters of a signature on one line
QUOTES = "'\""
_SECTION = re.compile(r"^(Args|Attributes|Raises|Returns):\n((?:    .*\n?|\n)+)", re.MULTILINE)
_ENTRY = re.compile(r"^(\S[^:\n]*): ", re.MULTILINE)
_TITLES = {
    "Args": "Arguments",
    "Attributes": "Attributes",
    "Raises": "Raises",
    "Returns": "Returns",
}


def api_page() -> str:
    """Return the page in Markdown: functions, then classes."""
    public = {name: getattr(crane_sim, name) for name in crane_sim.__all__}
    order = sorted(public.items(), key=lambda item: (inspect.isclass(item[1]), item[0].lower()))
    return (
        "\n".join(
            [HEAD, *(line for name, value in order for line in _api_section(name, value))]
        ).rstrip()
        + "\n"
    )


def save_api_page(folder: str | Path) -> None:
    """Write the page into a folder; SceneError: it cannot be written."""
    write_output("--save", Path(folder, "api.md"), lambda path: path.write_text(api_page()))


def _api_section(name: str, value: Any) -> Iterator[str]:
    yield f"## {name}\n"
    if inspect.isclass(value):
        yield f"{docstring(value)}\n"
        yield from _attributes(value)
        for method in _methods(value):
            yield from (
                f"{signature(method, prefix='run.' if name in RUNS else '')}\n",
                f"{docstring(method)}\n",
            )
    else:
        yield from (f"{signature(value)}\n", f"{docstring(value)}\n")


def signature(function: Callable[..., Any], prefix: str = "") -> str:
    """Return a function's first lines as a text block, one argument a line where they are long."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
    assert isinstance(tree, ast.FunctionDef)
    tree.args.args = [argument for argument in tree.args.args if argument.arg != "self"]
    arguments = re.sub(r"=(?=\S)", " = ", ast.unparse(tree.args))
    answer = f" -> {ast.unparse(tree.returns).strip(QUOTES)}" if tree.returns else ""
    line = f"{prefix}{tree.name}({arguments}){answer}"
    if len(line) > WIDEST:
        each = "".join(f"    {argument},\n" for argument in re.split(r", (?=\*|\w+:)", arguments))
        line = f"{prefix}{tree.name}(\n{each}){answer}"
    return f"```text\n{line}\n```"


def docstring(value: Any) -> str:
    """Return a docstring in Markdown, with its sections as lists."""
    return _SECTION.sub(_list, (inspect.getdoc(value) or "") + "\n").rstrip()


def _list(section: re.Match[str]) -> str:
    """Return a section of a docstring as a list."""
    entries = re.sub(r"\n {4,}", " ", textwrap.dedent(section[2]).rstrip())
    lines = (_ENTRY.sub(r"- `\1`: ", line, count=1) for line in entries.split("\n") if line)
    return f"{_TITLES[section[1]]}:\n\n" + "\n".join(lines) + "\n\n"


def _attributes(kind: type) -> Iterator[str]:
    """Yield a class's attributes as a list: fields with comments, properties with docstrings."""
    declared = getattr(kind, "__dataclass_fields__", {})
    described = comments(kind) if declared else {}
    for name, field in declared.items():
        text = described.get(name) or docstring(
            getattr(import_module(kind.__module__), str(field.type))
        )
        yield f"- `{name}`: {text}"
    for name, value in vars(kind).items():
        if not name.startswith("_") and isinstance(value, property | cached_property):
            yield f"- `{name}`: {' '.join(docstring(value).split())}"
    yield ""


def _methods(kind: type) -> list[Callable[..., Any]]:
    return [
        value
        for name, value in vars(kind).items()
        if inspect.isfunction(value) and not name.startswith("_")
    ]
