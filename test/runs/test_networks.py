"""Network interfaces of a run: loopback only by default, others with the profile for them."""

import json
import os
import shutil
import subprocess
import sys
import time
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from fnmatch import fnmatch
from pathlib import Path

import pytest
from process_helpers import run_to_completion, started_program, wait_until
from run_helpers import check_one_command_per_state

from crane_bench.soak.determinism import KILTED, clean_environment
from crane_sim import load_scene
from crane_sim.files.catalogue import config_folder
from crane_sim.orchestration.ros_environment import node_environment, reserve_domain
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.plant import Plant

PROGRAMS = Path(__file__).parents[1] / "programs"
EXAMPLES = Path(__file__).parents[2] / "examples"
LOOPBACK = "0100007F"  # 127.0.0.1 as /proc/net writes it
PROFILES = ("fastdds_loopback.xml", "fastdds_network.xml")
DURATION = 3.0  # s of simulated time


def can_isolate() -> bool:
    """Return whether this user may make network namespaces."""
    tools = all(shutil.which(tool) for tool in ("unshare", "nsenter", "ip"))
    return tools and run_to_completion(["unshare", "-Urn", "true"]).returncode == 0


def open_files(pid: int) -> list[str]:
    """Return what every open file descriptor of a process refers to."""
    links = []
    for descriptor in Path(f"/proc/{pid}/fd").iterdir():
        with suppress(
            FileNotFoundError
        ):  # closed since it was listed: a node that starts opens and closes files
            links.append(os.readlink(descriptor))
    return links


def sockets(pid: int) -> list[tuple[str, str]]:
    """Return (table, local address) of every internet socket that a process has open."""
    inodes = {link[8:-1] for link in open_files(pid) if link.startswith("socket:[")}
    addresses = []
    for table in ("udp", "udp6", "tcp", "tcp6"):
        for line in Path(f"/proc/{pid}/net/{table}").read_text().splitlines()[1:]:
            fields = line.split()
            if fields[9] in inodes:
                addresses.append((table, fields[1].partition(":")[0]))
    return addresses


@contextmanager
def started_node(module: str, env: dict[str, str], python: str = sys.executable) -> Iterator[int]:
    """Run a node of the default scene until it has opened its sockets; yield its process id."""
    command = [python, "-m", module, "--ros-args", "-r", "__ns:=/knuckle"]
    with started_program(command, env=env, stderr=subprocess.DEVNULL) as process:
        wait_until(lambda: len(sockets(process.pid)) >= 2, "the sockets of a node")
        time.sleep(0.5)  # s, in which it opens the others
        yield process.pid


def test_sockets_are_bound_to_loopback_by_default(ros_environment: dict[str, str]) -> None:
    """Every socket of a node is bound to the loopback interface."""
    with started_node("crane_sim.ros.plant_node", ros_environment) as pid:
        addresses = sockets(pid)
    assert len(addresses) >= 2  # discovery and data
    assert {address for _, address in addresses} == {LOOPBACK}, addresses


def test_a_missing_profile_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A mistyped profile would open every interface: it is an error instead."""
    monkeypatch.setenv("CRANE_SIM_DDS", str(tmp_path / "none.xml"))
    with pytest.raises(RuntimeError, match="none.xml: there is no such file"):
        node_environment(7, tmp_path)


def test_the_profiles_differ_by_their_interfaces_only() -> None:
    """Leases, announcements, buffers and repair are the same in both profiles."""
    leaves = []
    for name in PROFILES:
        root = ET.parse(config_folder() / name).getroot()
        elements = {(leaf.tag, (leaf.text or "").strip()) for leaf in root.iter() if not len(leaf)}
        leaves.append(
            {
                (tag, text)
                for tag, text in elements
                if text not in ("loopback", "network", "127.0.0.1")
            }
        )
    assert leaves[0] == leaves[1]


@pytest.mark.parametrize("name", PROFILES)
def test_newer_versions_have_the_same_profiles(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They differ by the name of one element, and a node of either version finds its own file."""
    monkeypatch.setenv("CRANE_SIM_DDS", str(config_folder() / name))
    env = node_environment(7, tmp_path)
    old, new = (env[f"{library}_DEFAULT_PROFILES_FILE"] for library in ("FASTRTPS", "FASTDDS"))
    assert (Path(old).name, Path(new).name) == (name, name.replace("fastdds", "fastdds3"))
    text = ET.canonicalize(Path(old).read_text(), with_comments=False)
    assert text.replace("heartbeatPeriod", "heartbeat_period") == ET.canonicalize(
        Path(new).read_text()
    )


@pytest.mark.skipif(not KILTED, reason="CRANE_SIM_KILTED_PYTHON names no Python with ROS 2 Kilted")
def test_sockets_of_a_newer_version_are_bound_to_loopback(tmp_path: Path) -> None:
    """Every socket of a node of ROS 2 Kilted is bound to the loopback interface, too."""
    with (
        reserve_domain() as domain,
        started_node(
            "crane_sim.ros.plant_node", clean_environment(KILTED, domain, tmp_path), KILTED
        ) as pid,
    ):
        addresses = sockets(pid)
    assert len(addresses) >= 2  # discovery and data
    assert {address for _, address in addresses} == {LOOPBACK}, addresses


def hash_of_example(scene: Scene) -> str:
    """Return the hash of the states of the example's law in this process."""
    sys.path.insert(0, str(EXAMPLES))
    from my_law import effort  # pyright: ignore[reportMissingImports]

    plant = Plant(scene.with_external_commands())
    for _ in range(scene.steps):
        plant.advance(effort(scene.joint_names, plant.q, plant.v))
    return plant.summary()["state_sha256"]


SERVICES_OF_AN_ACTION = ("/_action/send_goal", "/_action/cancel_goal", "/_action/get_result")
TOPICS_OF_AN_ACTION = ("/_action/feedback", "/_action/status")
ACTION_PARTS = {
    "execute": {"publish": TOPICS_OF_AN_ACTION, "reply": SERVICES_OF_AN_ACTION},
    "call": {"subscribe": TOPICS_OF_AN_ACTION, "request": SERVICES_OF_AN_ACTION},
}


def allowed_names(name: str) -> dict[str, list[str]]:
    """Return the full names that the SROS2 policy allows a node, by what it does with them."""
    names: dict[str, list[str]] = {}
    for profile in ET.parse(config_folder() / "sros2_policy.xml").getroot().iter("profile"):
        if profile.get("node") == name:
            for group in profile:
                ((what, rule),) = group.attrib.items()
                assert rule == "ALLOW"
                full_names = [
                    full_name(entry.text or "", profile.get("ns", ""), name) for entry in group
                ]
                for part, parts in ACTION_PARTS.get(what, {what: ("",)}).items():
                    names.setdefault(part, []).extend(
                        f"{each}{end}" for each in full_names for end in parts
                    )
    return names


def full_name(name: str, namespace: str, node: str) -> str:
    """Return the full name of a topic or service."""
    if name.startswith("/"):
        return name
    return f"{namespace}/{name.replace('~', node)}"


def names_beyond_the_policy(programs: dict[str, list[str]], env: dict[str, str]) -> list[str]:
    """Return what nodes, by module and arguments, publish, subscribe or offer beyond the policy.

    The policy is that of SROS2.
    """
    names = [module.split(".")[-1].removesuffix("_node") for module in programs]
    with ExitStack() as nodes:
        for module, own in programs.items():
            words = [sys.executable, "-m", module, "--ros-args", "-r", "__ns:=/knuckle", *own]
            nodes.enter_context(started_program(words, env=env))
        lister = [sys.executable, PROGRAMS / "graph_lister.py", "/knuckle", *names]
        listing = run_to_completion(lister, env=env, check=True)
    return [
        f"{node} {what} {name}"
        for node, does in json.loads(listing.stdout).items()
        for what, names in does.items()
        for name in names
        if not any(fnmatch(name, rule) for rule in allowed_names(node).get(what, []))
    ]


@pytest.mark.long
def test_the_policy_allows_the_topics_and_services_of_the_nodes(
    tmp_path: Path, ros_environment: dict[str, str]
) -> None:
    """Everything that plant, controller, operator and recorder publish and offer is in the policy.

    So is what they subscribe to.
    """
    programs = {
        "crane_sim.ros.plant_node": ["-p", "expected_controllers:=3"],
        "crane_control.nodes.controller_node": [],
        "crane_control.nodes.operator_node": [],
        "crane_sim.ros.recorder_node": [
            "-p",
            f"path:={tmp_path / 'run.rrd'}",
            "-p",
            f"mcap:={tmp_path / 'run.mcap'}",
        ],
    }
    assert not names_beyond_the_policy(programs, ros_environment)


@pytest.mark.long
@pytest.mark.parametrize("scene", ["knuckle_sea", "knuckle_bench", "bridge_speed_drive"])
def test_the_policy_allows_the_topics_of_every_plant(
    scene: str, ros_environment: dict[str, str]
) -> None:
    """Moving bases with instruments, sensors, and drives by speed: the policy has their topics."""
    own = ["-p", f"scene:={scene}", "-p", "mode:=realtime"]
    assert not names_beyond_the_policy({"crane_sim.ros.plant_node": own}, ros_environment)


def test_a_secure_node_needs_valid_keys(tmp_path: Path, ros_environment: dict[str, str]) -> None:
    """A node with enforced security and invalid keys exits with an error.

    It does not communicate openly instead.
    """
    folder = tmp_path / "enclaves"
    folder.mkdir()
    for name in "identity_ca.cert.pem cert.pem key.pem permissions_ca.cert.pem governance.p7s permissions.p7s".split():  # noqa: E501
        (folder / name).write_text("no key\n")
    secure = {
        "ROS_SECURITY_ENABLE": "true",
        "ROS_SECURITY_STRATEGY": "Enforce",
        "ROS_SECURITY_KEYSTORE": str(tmp_path),
    }
    command = [sys.executable, "-m", "crane_sim.ros.plant_node"]
    run = run_to_completion(command, env=ros_environment | secure)
    assert run.returncode == 2
    assert "Traceback" not in run.stderr


@pytest.mark.skipif(not can_isolate(), reason="this user may not make network namespaces")
def test_a_controller_on_another_machine() -> None:
    """With the network profile a controller in another network namespace drives the crane.

    It does so bit for bit as locally.
    """
    env = os.environ | {"CRANE_SIM_DDS": str(config_folder() / "fastdds_network.xml")}
    command = [
        "unshare",
        "-Urn",
        "sh",
        PROGRAMS / "two_machines.sh",
        sys.executable,
        EXAMPLES,
        str(DURATION),
    ]
    run = run_to_completion(command, env=env)
    summary = json.loads(run.stdout.splitlines()[-1])
    assert "error" not in summary
    scene = load_scene("knuckle_setpoint", {"duration": DURATION})
    check_one_command_per_state(summary, scene.steps)
    assert summary["state_sha256"] == hash_of_example(scene)
