"""The ROS package `crane_sim`: an ament_python package that is also an ordinary Python one."""

from glob import glob

from setuptools import find_packages, setup

NAME = "crane_sim"
# a file of crane_control each:
LAWS = (
    "energy",
    "lqr",
    "cartesian",
    "angular",
    "adaptive",
    "harmonic",
    "anti_swing",
    "joint_trajectory",
)
# commands of crane_bench:
LABORATORY = ("bench", "league", "soak", "reproduce", "docs", "describe")

setup(
    name=NAME,
    version="0.3.0",
    description="An accurate and fast crane simulator of ROS 2 nodes",
    author="The crane simulator authors",
    maintainer="The crane simulator authors",
    maintainer_email="maintainers@crane-simulator.example.org",
    license="Apache-2.0",
    packages=find_packages(include=["crane_sim*", "crane_control*", "crane_bench*"]),
    package_data={
        "crane_bench": ["pages/*"],
        "crane_bench.documentation": ["signs.yaml"],
        "crane_bench.league": ["cases.yaml"],
        "crane_bench.reproduce": ["offshore.yaml"],
        "crane_bench.speed": ["groups.yaml", "floor/*", "peers/*.cpp"],
        "crane_sim.report.assets": ["*.*"],
    },
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/config", glob("config/*.*")),
        (f"share/{NAME}/launch", glob("launch/*.launch.py")),
        (f"share/{NAME}/config/scenes", glob("config/scenes/*.yaml")),
        (f"share/{NAME}/config/references", glob("config/references/*.json")),
    ],
    python_requires=">=3.11",
    install_requires=[
        "setuptools",
        "numpy>=2",
        "scipy",
        "threadpoolctl",
        "llvmlite",
        "pydantic",
        "pyyaml",
        "rich",
        "click",
    ],
    extras_require={
        "ros": [
            "ros-diagnostic-msgs==5.3.6",
            "ros-geometry-msgs==5.3.6",
            "ros-nav-msgs==5.3.6",
            "ros-rclpy[fastrtps]==7.1.6",
            "ros-rosgraph-msgs==2.0.3",
            "ros-sensor-msgs==5.3.6",
            "ros-std-msgs==5.3.6",
            "ros-std-srvs==5.3.6",
            "ros-trajectory-msgs==5.3.6",
        ],
        "rerun": ["rerun-sdk==0.41.*"],
        "mcap": ["rosbags", "mcap"],
        "plots": ["matplotlib"],
        "pandas": ["pandas"],
        "study": ["pyarrow", "dask", "distributed", "optuna", "salib", "jinja2"],
        "gym": ["gymnasium"],
        "gamepad": ["evdev"],
        "docs": ["zensical==0.0.*"],
        "peers": ["mujoco", "pin", "casadi", "heyoka"],
        "bench": ["jinja2", "matplotlib"],
        "test": ["pytest", "pytest-xdist", "hypothesis", "sympy", "mpmath"],
    },
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "crane = crane_sim.cli:main",
            "plant_node = crane_sim.ros.plant_node:main",
            "recorder_node = crane_sim.ros.recorder_node:main",
            "controller_node = crane_control.nodes.controller_node:main",
            "tracker_node = crane_control.nodes.tracker_node:main",
            "operator_node = crane_control.nodes.operator_node:main",
        ],
        "crane_sim.commands": [f"{name} = crane_bench.cli.commands:{name}" for name in LABORATORY],
        "crane_sim.views": [
            "record = crane_sim.recording.rerun.rollout:record",
            "plot = crane_sim.report.figure:plot",
            "show = crane_sim.report.page:show",
        ],
        "crane_sim.laws": [f"{name} = crane_control.{name}:build" for name in LAWS],
    },
)
