"""Other engines, one file each, behind the interface of `engine`."""
