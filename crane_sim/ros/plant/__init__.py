"""Parts of the node `plant`."""
