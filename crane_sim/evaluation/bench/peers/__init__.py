"""Other engines, one file each, behind the interface of `engine`."""

from crane_sim.evaluation.bench.engine import Engine, Missing
from crane_sim.evaluation.bench.peers.casadi_c import CasadiC
from crane_sim.evaluation.bench.peers.drake_engine import Drake
from crane_sim.evaluation.bench.peers.floor import Floor
from crane_sim.evaluation.bench.peers.mujoco_engine import MuJoCo
from crane_sim.evaluation.bench.peers.pinocchio_engine import Pinocchio
from crane_sim.evaluation.bench.peers.scipy_ivp import Scipy

FLOOR, PEERS = (Floor,), (Floor, CasadiC, Pinocchio, MuJoCo, Drake, Scipy)
GENERAL = ("Pinocchio", "MuJoCo", "Drake")
"""General multibody engines."""


def engines(every: bool) -> tuple[list[Engine], dict[str, str]]:
    """Return (the engines that are there, why the others are not, by name): every one, or only the hand-written C."""
    present: list[Engine] = []
    missing: dict[str, str] = {}
    for kind in PEERS if every else FLOOR:
        try:
            present.append(kind())
        except Missing as error:
            missing[kind.name] = str(error)
    return present, missing
