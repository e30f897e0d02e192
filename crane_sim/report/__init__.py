"""Pictures of a run from its recording: a figure, and one self-contained HTML page that plays it."""
