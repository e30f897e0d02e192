"""Pages of documentation that commands write: which ones there are, and the format of scene files from its schemas."""
