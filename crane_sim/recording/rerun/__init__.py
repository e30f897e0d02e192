"""Rerun recordings of a run: the only modules that import Rerun."""

import os

# read when Rerun is imported; the footer of a long recording is left out on purpose
os.environ.setdefault("RUST_LOG", "warn,re_log_encoding::rrd::file_sink=error")
