"""Cables turn the tip's motion and the payload's into tensions. One file each."""
