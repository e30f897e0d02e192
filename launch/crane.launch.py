"""Starts a crane with `ros2 launch`: plant, controller, recorder, robot_state_publisher.

For colcon workspaces: `ros2 launch crane_sim crane.launch.py scene:=tower_gust`. Without launch,
`./crane run` does the same and more (it replaces processes that die, and reports). The plant's end
ends all of it.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, RegisterEventHandler, Shutdown
from launch.conditions import IfCondition
from launch.event_handlers import OnProcessExit
from launch.substitutions import (
    Command,
    LaunchConfiguration,
    PathJoinSubstitution,
    PythonExpression,
)
from launch_ros.actions import LifecycleNode, Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackagePrefix, FindPackageShare

PACKAGE = "crane_sim"
FINISH_TIME = "60"  # s, that a recorder has to complete its files

ARGUMENTS = (
    ("scene", "knuckle_setpoint", "a name of the catalogue or a path"),
    ("namespace", "crane", "of all nodes"),
    (
        "frame_prefix",
        "",
        "begins names of frames, such as west/; a robot_state_publisher prefixes world, too",
    ),
    (
        "mode",
        "lockstep",
        "lockstep: every state waits for its command; realtime: at the wall clock",
    ),
    ("controller", "true", "evaluate the scene's law; false: your node commands"),
    ("record", "true", "write a Rerun recording"),
    ("path", "runs/run.rrd", "of the recording"),
    (
        "state_publisher",
        "false",
        "start a robot_state_publisher; the plant's transforms are then the base's alone",
    ),
    ("autostart", "true", "nodes activate themselves; false: a manager of lifecycles does"),
    (
        "parameters",
        PathJoinSubstitution([FindPackageShare(PACKAGE), "config", "parameters.yaml"]),
        "a parameter file",
    ),
)


def crane_nodes(config: dict[str, LaunchConfiguration]) -> list[Node]:
    """Return the crane's own nodes, the plant first."""
    shared = {
        "namespace": config["namespace"],
        "package": PACKAGE,
        "output": "screen",
        "emulate_tty": True,
    }
    shared |= {"sigterm_timeout": FINISH_TIME, "sigkill_timeout": FINISH_TIME}
    scene, mode = {"scene": config["scene"]}, {"mode": config["mode"]}
    managed = {"autostart": ParameterValue(config["autostart"], value_type=bool)}
    plant = {
        "expected_controllers": one_if(config["controller"]),
        "expected_recorders": one_if(config["record"]),
        "commanded": inverse(config["controller"]),
        "frame_prefix": ParameterValue(config["frame_prefix"], value_type=str),
        "publish_tf": PythonExpression(
            ["'base' if '", config["state_publisher"], "' == 'true' else 'all'"]
        ),
    }
    watched = {"expected_recorders": one_if(config["record"])}
    return [
        LifecycleNode(
            name="plant",
            executable="plant_node",
            parameters=[config["parameters"], scene, mode, managed, plant],
            **shared,
        ),
        LifecycleNode(
            name="controller",
            executable="controller_node",
            parameters=[config["parameters"], scene, mode, managed, watched],
            condition=IfCondition(config["controller"]),
            **shared,
        ),
        Node(
            name="recorder",
            executable="recorder_node",
            parameters=[config["parameters"], scene, {"path": config["path"]}],
            condition=IfCondition(config["record"]),
            **shared,
        ),
    ]


def one_if(choice: LaunchConfiguration) -> ParameterValue:
    """Return 1 for an argument that is true, else 0."""
    return ParameterValue(PythonExpression(["int('", choice, "' == 'true')"]), value_type=int)


def inverse(choice: LaunchConfiguration) -> ParameterValue:
    """Return whether an argument is not true."""
    return ParameterValue(PythonExpression(["'", choice, "' != 'true'"]), value_type=bool)


def state_publisher(config: dict[str, LaunchConfiguration]) -> Node:
    """Return the robot_state_publisher of the crane."""
    crane = PathJoinSubstitution([FindPackagePrefix(PACKAGE), "lib", PACKAGE, "crane"])
    description = ParameterValue(Command([crane, " urdf ", config["scene"]]), value_type=str)
    prefix = ParameterValue(config["frame_prefix"], value_type=str)
    return Node(
        package="robot_state_publisher",
        executable="robot_state_publisher",
        namespace=config["namespace"],
        parameters=[
            {"robot_description": description, "use_sim_time": True, "frame_prefix": prefix}
        ],
        # the plant publishes its own, which has the ros2_control tag, too
        remappings=[("robot_description", "state_publisher/robot_description")],
        condition=IfCondition(config["state_publisher"]),
    )


def generate_launch_description() -> LaunchDescription:
    """Return what `ros2 launch` starts."""
    config = {name: LaunchConfiguration(name) for name, _, _ in ARGUMENTS}
    declared = [
        DeclareLaunchArgument(name, default_value=value, description=what)
        for name, value, what in ARGUMENTS
    ]
    nodes = crane_nodes(config)
    end = OnProcessExit(target_action=nodes[0], on_exit=[Shutdown(reason="the plant has ended")])
    return LaunchDescription(
        [*declared, *nodes, state_publisher(config), RegisterEventHandler(end)]
    )
