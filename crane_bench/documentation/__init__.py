"""Pages of documentation that commands write, and the format of scene files from its schemas."""
