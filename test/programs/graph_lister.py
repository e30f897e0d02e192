"""Prints as JSON what nodes publish, subscribe to, serve and call, once settled. Plain rclpy."""

import json
import sys
import time

import rclpy
from rclpy.node import Node

SETTLED = 4.0  # s without a change
LIMIT = 300.0  # s for the nodes to start and settle


def list_names(node: Node, namespace: str, name: str) -> dict[str, list[str]]:
    """Return the names of a node's topics and services, by what it does with them."""
    queries = {
        "publish": lambda: node.get_publisher_names_and_types_by_node(name, namespace),
        "subscribe": lambda: node.get_subscriber_names_and_types_by_node(name, namespace),
        "reply": lambda: node.get_service_names_and_types_by_node(name, namespace),
        "request": lambda: node.get_client_names_and_types_by_node(name, namespace),
    }
    return {what: sorted(topic for topic, _ in query()) for what, query in queries.items()}


def main() -> None:
    """List the nodes on the command line, of one namespace, when all of them are in the graph."""
    rclpy.init()
    node, (namespace, *names) = rclpy.create_node("graph_lister"), sys.argv[1:]
    names_by_node, since, deadline = {}, time.monotonic(), time.monotonic() + LIMIT
    while time.monotonic() - since < SETTLED:
        assert time.monotonic() < deadline, f"not settled within {LIMIT:g} s: {names_by_node}"
        rclpy.spin_once(node, timeout_sec=0.1)
        present = {
            name for name, where in node.get_node_names_and_namespaces() if where == namespace
        }
        newest = (
            {name: list_names(node, namespace, name) for name in names}
            if present.issuperset(names)
            else {}
        )
        if newest != names_by_node or not newest:
            names_by_node, since = newest, time.monotonic()
    print(json.dumps(names_by_node))


if __name__ == "__main__":
    main()
