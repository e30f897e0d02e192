"""Server of a run's recording to viewers on this machine while the run goes on."""

from __future__ import annotations

import socket

import rerun as rr

from crane_sim.recording.rerun.part_file import RecordingError

ADDRESS = "127.0.0.1"


def live_address(port: int) -> str:
    """Return the address under which viewers find the server of a port."""
    return f"rerun+http://{ADDRESS}:{port}/proxy"


class LiveServer:
    """Server on a loopback port; it outlives resets, after which a new recording begins."""

    def __init__(self, port: int) -> None:
        """Check that the port is free.

        Raises:
            RecordingError: another program has it.
        """
        with socket.socket() as probe:
            try:
                probe.bind((ADDRESS, port))
            except OSError as error:
                raise RecordingError(f"live port {port}: {error.strerror}") from error
        self._port = port
        self._stream: rr.RecordingStream | None = None

    def sink(self, application: str, run_id: str) -> rr.GrpcSink:
        """Return where a recording of this id is also written; the first one starts the server."""
        if self._stream is None:
            # of the same id: another one would be listed by viewers as a recording without data
            self._stream = rr.RecordingStream(application, recording_id=run_id)
            self._stream.set_sinks(rr.GrpcServerSink(ADDRESS, self._port))
        return rr.GrpcSink(live_address(self._port))
