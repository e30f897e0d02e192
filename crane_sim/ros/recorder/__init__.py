"""Parts of the node `recorder`."""
