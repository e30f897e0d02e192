"""Pictures of a run from its recording: a figure, and a self-contained HTML page that plays it."""
