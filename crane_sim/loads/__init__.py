"""What hangs below the cable."""
