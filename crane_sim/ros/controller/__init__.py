"""Parts of the nodes `controller` and `tracker`."""
