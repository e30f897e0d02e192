"""The environment of ROS nodes: domain id, profile of Fast DDS, search paths."""

import os
import socket
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from crane_sim.environment import admitted, own_ros
from crane_sim.files.catalogue import config_folder

DOMAINS = range(1, 102)  # above 101 the ports of a domain overlap the kernel's ephemeral ports


@contextmanager
def reserve_domain(domain_id: int | None = None) -> Iterator[int]:
    """Yield a ROS domain id: `domain_id`, or one that no other process on this machine reserves.

    Raises:
        RuntimeError: all are taken; the message is one line.
    """
    if domain_id is not None:
        yield domain_id
        return
    first = os.getpid() % len(DOMAINS)
    for domain in (*DOMAINS[first:], *DOMAINS[:first]):
        with closing(socket.socket(socket.AF_UNIX)) as lock:
            try:
                # abstract name: the kernel frees it when this process ends
                lock.bind(f"\0crane_sim domain {domain}")
            except OSError:
                continue
            if not _is_in_use(domain):
                yield domain
                return
    raise RuntimeError(f"no free ROS domain id between {DOMAINS[0]} and {DOMAINS[-1]}")


def _is_in_use(domain: int) -> bool:
    # discovery: the multicast port, then one unicast port per participant
    base = 7400 + 250 * domain
    for port in (base, *range(base + 10, base + 20, 2)):
        with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as probe:
            try:
                probe.bind(("", port))
            except OSError:
                return True
    return False


def node_environment(domain: int, log_folder: Path) -> dict[str, str]:
    """Return a node's environment in `domain`: Fast DDS over loopback, this package, its ROS.

    Of the variables that ROS, Fast DDS, Python and the loader read it has those of a list only
    (`environment`): any other could choose another discovery, transport or ROS than the one that
    the simulator is tested with.

    Raises:
        RuntimeError: the environment names a profile of Fast DDS that does not exist; the message
            is one line.
    """
    profile = os.path.abspath(
        os.environ.get("CRANE_SIM_DDS") or config_folder() / "fastdds_loopback.xml"
    )
    if not os.path.isfile(profile):  # Fast DDS would silently use every interface
        raise RuntimeError(f"CRANE_SIM_DDS = {profile}: there is no such file")
    # Fast DDS 3 rejects a file of version 2, where one element has another name
    folder, name = os.path.split(profile)
    newer = os.path.join(folder, name.replace("fastdds_", "fastdds3_", 1))
    fixed = {
        "ROS_DOMAIN_ID": str(domain),
        # LOCALHOST would override the profile's transports
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT",
        "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp",
        "FASTRTPS_DEFAULT_PROFILES_FILE": profile,  # Jazzy
        "FASTDDS_DEFAULT_PROFILES_FILE": newer
        if os.path.isfile(newer)
        else profile,  # Kilted and later
        # a profile in the working directory, which Fast DDS would read as well
        "SKIP_DEFAULT_XML_FILE": "1",
    }
    defaults = {"ROS_LOG_DIR": str(log_folder)}
    return defaults | admitted(os.environ) | _search_paths() | fixed


def _search_paths() -> dict[str, str]:
    """Return the search paths of nodes: this package and the ROS beside it come first."""
    package_root, own = str(Path(__file__).parents[2]), own_ros()
    own["PYTHONPATH"] = [package_root, *own.get("PYTHONPATH", [])]
    paths = {
        name: [*folders, *filter(None, [os.environ.get(name)])] for name, folders in own.items()
    }
    # in no random order
    bootstrapped = {"_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1"} if "LD_LIBRARY_PATH" in own else {}
    return {name: os.pathsep.join(folders) for name, folders in paths.items()} | bootstrapped
