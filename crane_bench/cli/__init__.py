"""The commands of the laboratory, which `crane` finds by entry points."""
