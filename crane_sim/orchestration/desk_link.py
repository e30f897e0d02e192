"""The link between an operator's terminal and the node `operator` of a run."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple, Protocol

from crane_sim.orchestration.roles import Role

OPERATOR = "operator"
"""Name of the role of an operator's node."""
QUIT = "quit"
"""Order to the plant that ends a run before its time, on purpose."""


class DeskLink(NamedTuple):
    """An operator's access to a run at this terminal; any thread may call its functions."""

    send: Callable[[str], None]  # a line to the node
    panel: Callable[[], Mapping[str, Any]]  # what the node has reported to show
    end: Callable[[], None]  # ends the run, on purpose


class Operator(Protocol):
    """The operator of a run at this terminal.

    Attributes:
        parameters: of the node `operator`, beside its scene.
    """

    parameters: Mapping[str, object]

    def begin(self, desk: DeskLink) -> None:
        """Begin the operation: the run is about to start."""
        ...


def desk_link(roles: Sequence[Role]) -> DeskLink:
    """Return the link to a run of these roles, the plant's first."""
    node = next(role for role in roles if role.name == OPERATOR)
    return DeskLink(
        lambda line: node.active.send(line),
        lambda: node.active.panel,
        partial(roles[0].active.send, QUIT),
    )
