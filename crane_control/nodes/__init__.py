"""The nodes that run laws."""
