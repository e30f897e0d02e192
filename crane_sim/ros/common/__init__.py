"""Parts of all nodes: parameters, lifecycle, messages, serialization, timing."""
