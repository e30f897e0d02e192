"""A controller without ROS: plain DDS by the Python package `cyclonedds`.

It is for `./crane run --no-controller --domain-id 7`.

A topic of ROS 2 is a topic of DDS with `rt` before its name; its type is a struct in a module
`dds_`, and has an underscore behind the name of the type and of each field. `python plain_dds.py 7`
commands the crane in domain 7 until the plant has left.
"""

import os
import sys
from dataclasses import dataclass

from cyclonedds.core import (
    InstanceState,
    Policy,
    Qos,
    ReadCondition,
    SampleState,
    ViewState,
    WaitSet,
)
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import float64, int32, sequence, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from my_law import TARGET, effort

LOOPBACK = """<CycloneDDS><Domain><General><AllowMulticast>false</AllowMulticast><Interfaces>
<NetworkInterface address="127.0.0.1"/></Interfaces></General><Discovery><ParticipantIndex>auto</ParticipantIndex>
<MaxAutoParticipantIndex>31</MaxAutoParticipantIndex><Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain>
</CycloneDDS>"""  # noqa: E501
RELIABLE = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(10))
ANY = SampleState.Any | ViewState.Any | InstanceState.Any


@dataclass
class Time(IdlStruct, typename="builtin_interfaces.msg.dds_.Time_"):
    """A stamp."""

    sec_: int32
    nanosec_: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs.msg.dds_.Header_"):
    """When, and in which frame."""

    stamp_: Time
    frame_id_: str


@dataclass
class JointState(IdlStruct, typename="sensor_msgs.msg.dds_.JointState_"):
    """Positions, velocities and efforts by joint name."""

    header_: Header
    name_: sequence[str]
    position_: sequence[float64]
    velocity_: sequence[float64]
    effort_: sequence[float64]


def main(domain_id: int) -> None:
    """Answer every state with a command that echoes its stamp."""
    os.environ.setdefault("CYCLONEDDS_URI", LOOPBACK)
    crane = DomainParticipant(domain_id)
    states = DataReader(
        crane, Topic(crane, "rt/knuckle/joint_states", JointState, qos=RELIABLE), qos=RELIABLE
    )
    commands = DataWriter(
        crane, Topic(crane, "rt/knuckle/joint_commands", JointState, qos=RELIABLE), qos=RELIABLE
    )
    arrival = WaitSet(crane)
    arrival.attach(ReadCondition(states, ANY))
    while True:
        arrival.wait(
            duration(seconds=1)
        )  # Ctrl-C is heard in between; a pause may last as long as it likes
        for state in states.take(10):
            if not state.sample_info.valid_data:
                return  # the plant has left
            efforts = effort(state.name_, state.position_, state.velocity_)
            commands.write(JointState(state.header_, list(TARGET), [], [], efforts))


if __name__ == "__main__":
    main(int(sys.argv[1]))
