"""Parts of the node `operator`."""
