"""The same runs on an existing Dask cluster, by the address of its scheduler.

Dask schedules, moves and repeats; here a job goes in and its outcome comes out. Workers need this very
navtwin: their sources are compared with ours before the first run, because otherwise results would be of two
products.
"""

from __future__ import annotations

import asyncio
import importlib.util
import logging
import socket
from collections.abc import Iterable, Iterator
from concurrent.futures import CancelledError
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from boards.places import board_folder
from host.campaign.identity import sources_digest
from host.campaign.journal import Outcome
from host.campaign.plan import Job
from host.campaign.row import failed
from host.campaign.work import Reduce, work
from host.record.errors import UserError

PATIENCE_S = 5
EXAMPLE = "for example --scheduler tcp://192.168.1.10:8786"
SCHEMES = ("tcp", "tls", "ws", "wss")


class Cluster:
    """An existing cluster. Raises UserError when it cannot be used."""

    def __init__(self, address: str, reduce: Reduce) -> None:
        if importlib.util.find_spec("distributed") is None:
            raise UserError("--scheduler needs Dask, which is not installed: pip install 'navtwin[dask]'")
        self._place = _host_and_port(address)
        self._address = address
        self._reduce = reduce

    def outcomes(self, jobs: Iterable[Job]) -> Iterator[Outcome]:
        """Do all jobs; outcomes come as runs end. Leaving early cancels what waits."""
        from distributed import as_completed

        listed = list(jobs)
        client = self._client()
        try:
            self._must_have_our_sources(client, board_folder(listed[0].request.board))
            futures = {client.submit(work, job, self._reduce, pure=False): job for job in listed}
            for future in as_completed(list(futures), loop=client.loop):
                yield self._outcome(future, futures.pop(future))
        except (CancelledError, asyncio.CancelledError, OSError) as error:
            raise UserError(
                f"--scheduler {self._address}: the cluster was lost ({error}); finished runs are kept, the"
                " same command goes on from there"
            ) from None
        finally:
            client.close()

    def _client(self) -> Any:
        from distributed import Client

        self._must_answer()
        logging.getLogger("distributed").setLevel(logging.CRITICAL)
        try:
            client = Client(self._address, timeout=PATIENCE_S, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            raise UserError(
                f"--scheduler {self._address}: cannot be reached within {PATIENCE_S} s"
                f" ({type(error).__name__}); is it running? {EXAMPLE}"
            ) from None
        if not client.scheduler_info()["workers"]:
            client.close()
            raise UserError(f"--scheduler {self._address}: has no workers; start some: dask worker ADDRESS")
        return client

    def _must_answer(self) -> None:
        """Before Dask: a client of its that never came up complains for long when it is collected."""
        try:
            socket.create_connection(self._place, timeout=PATIENCE_S).close()
        except OSError as error:
            raise UserError(
                f"--scheduler {self._address}: cannot be reached within {PATIENCE_S} s"
                f" ({type(error).__name__}); is it running? {EXAMPLE}"
            ) from None
        if self._address.startswith(("tls://", "wss://")):
            from distributed.security import Security

            if Security().get_connection_args("client")["ssl_context"] is None:
                raise UserError(
                    f"--scheduler {self._address}: needs certificates, and Dask's configuration names none"
                    " (distributed.comm.tls.ca-file, .client.cert, .client.key)"
                )

    def _must_have_our_sources(self, client: Any, board: Path) -> None:
        ours = sources_digest(board)
        try:
            theirs = client.run(sources_digest, board)
        except Exception as error:  # whatever unpickling or importing there has raised
            raise UserError(
                f"--scheduler {self._address}: its workers do not have this navtwin installed ({error})"
            ) from None
        other = [worker for worker, digest in theirs.items() if digest != ours]
        if other:
            raise UserError(
                f"--scheduler {self._address}: the worker {other[0]} has other sources of navtwin or of the"
                " board; install the same ones everywhere"
            )

    @staticmethod
    def _outcome(future: Any, job: Job) -> Outcome:
        """What a future holds; one that failed, failed for a reason that lies in the cluster."""
        if future.status == "finished":
            outcome: Outcome = future.result()
            return outcome
        if future.status == "cancelled":
            raise CancelledError("the scheduler forgot a run")
        error = future.exception()
        row = failed(job, f"the cluster gave the run up: {type(error).__name__}")
        return Outcome(job.key, job.number, row, times={"traceback": str(error)}, again=True)


def _host_and_port(address: str) -> tuple[str, int]:
    try:
        parts = urlsplit(address)
        host, port = parts.hostname, parts.port
    except ValueError:
        host = port = None
    if not host or not port or parts.scheme not in SCHEMES:
        raise UserError(f"--scheduler {address}: must be the address of a Dask scheduler; {EXAMPLE}")
    return host, port
