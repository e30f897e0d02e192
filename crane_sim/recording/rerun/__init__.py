"""Rerun recordings of a run: the only modules that import Rerun.

Importing one raises `MissingPackage`, one line, where Rerun is not installed.
"""

import os

from crane_sim.files.installation import require

require("rerun", "a recording")

# read when Rerun is imported; the writer reports what a disk refuses, and leaves out the footer of
# a long recording
os.environ.setdefault(
    "RUST_LOG", "warn,re_log_encoding::rrd=off,re_sdk::recording_stream=off,re_sdk::log_sink=off"
)
