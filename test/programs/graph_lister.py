"""Prints as JSON what nodes publish, subscribe to, serve and call, once it is the same for a second. Plain rclpy."""

import json
import sys
import time

import rclpy
from rclpy.node import Node

SETTLED = 4.0  # s without a change


def graph(node: Node, namespace: str, name: str) -> dict[str, list[str]]:
    """Return the names of a node's topics and services, by what it does with them."""
    questions = {
        "publish": lambda: node.get_publisher_names_and_types_by_node(name, namespace),
        "subscribe": lambda: node.get_subscriber_names_and_types_by_node(name, namespace),
        "reply": lambda: node.get_service_names_and_types_by_node(name, namespace),
        "request": lambda: node.get_client_names_and_types_by_node(name, namespace),
    }
    return {what: sorted(topic for topic, _ in ask()) for what, ask in questions.items()}


def main() -> None:
    """Look at the nodes named on the command line, all in one namespace, when all of them are there."""
    rclpy.init()
    node, (namespace, *names) = rclpy.create_node("graph_lister"), sys.argv[1:]
    seen, since = {}, time.monotonic()
    while time.monotonic() - since < SETTLED:
        rclpy.spin_once(node, timeout_sec=0.1)
        present = {name for name, where in node.get_node_names_and_namespaces() if where == namespace}
        now = {name: graph(node, namespace, name) for name in names} if present.issuperset(names) else {}
        if now != seen or not now:
            seen, since = now, time.monotonic()
    print(json.dumps(seen))


if __name__ == "__main__":
    main()
