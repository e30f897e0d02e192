"""Rerun recordings of a run: the only modules that import Rerun."""

import os

# read when Rerun is imported; the writer reports what a disk refuses, and leaves out the footer of a long recording
os.environ.setdefault("RUST_LOG", "warn,re_log_encoding::rrd=off,re_sdk::recording_stream=off,re_sdk::log_sink=off")
