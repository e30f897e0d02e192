"""Rerun recordings of a run: the only modules that import Rerun.

Importing one raises `MissingPackage`, one line, where Rerun is not installed.
"""

import os

from crane_sim.files.installation import require

require("rerun", "a recording")

# read when Rerun is imported; the footer of a long recording is left out on purpose
os.environ.setdefault("RUST_LOG", "warn,re_log_encoding::rrd::file_sink=error")
