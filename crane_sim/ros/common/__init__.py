"""What nodes share: parameters, lifecycle, messages, serialization, timing."""
