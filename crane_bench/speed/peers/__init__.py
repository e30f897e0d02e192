"""Other engines, one file each, behind the interface of `engine`."""

from crane_bench.speed.engine import Engine, EngineUnavailable
from crane_bench.speed.peers.casadi_c import CasadiC
from crane_bench.speed.peers.hand_c import HandC
from crane_bench.speed.peers.heyoka_taylor import Heyoka
from crane_bench.speed.peers.mujoco_engine import MuJoCo
from crane_bench.speed.peers.pinocchio_engine import Pinocchio
from crane_bench.speed.peers.scipy_ivp import Scipy

HAND_C, PEERS = (HandC,), (HandC, CasadiC, Heyoka, Pinocchio, MuJoCo, Scipy)
GENERAL = ("Pinocchio", "MuJoCo")
"""General multibody engines."""


def engines(every: bool) -> tuple[list[Engine], dict[str, str]]:
    """Return (available engines, reasons of the others by name).

    Only the hand-written C is included unless `every`.
    """
    available: list[Engine] = []
    unavailable: dict[str, str] = {}
    for kind in PEERS if every else HAND_C:
        try:
            available.append(kind())
        except EngineUnavailable as error:
            unavailable[kind.name] = str(error)
    return available, unavailable
