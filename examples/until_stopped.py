"""Serves a node until SIGINT or SIGTERM, which may come at any time, also while rclpy starts."""

import signal
from collections.abc import Callable

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

POLL = 0.1  # s in which rclpy comes back, so that Python hears of a signal


def spin_until_stopped(make: Callable[[], Node]) -> None:
    """Make a node and serve its callbacks.

    A signal ends that in order, so that the node leaves the graph at once.

    rclpy's own handlers are left out: behind them a signal that comes before `spin` ends in an
    exception, or is lost.
    """
    stopped: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda came, _: stopped.append(came))
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node, executor = make(), SingleThreadedExecutor()
    executor.add_node(node)
    while not stopped:
        executor.spin_once(timeout_sec=POLL)
    executor.shutdown()
    node.destroy_node()
    rclpy.shutdown()
