"""Cases on an existing Dask cluster."""

from __future__ import annotations

from concurrent.futures import Executor
from typing import Any

from flatland.errors import InputError, bad_input
from studies.sweeps.engines import Engine, EngineLostError

#: Tasks under way per thread of the cluster, so that no worker waits for the next one.
_AHEAD = 2
#: How long to look for the scheduler [s].
_PATIENCE = 10


class Dask(Engine):
    """The cluster whose scheduler listens at an address, such as tcp://127.0.0.1:8786.

    Its workers need this package, in the same version: an answer of other code is refused. Dask
    itself runs a task again when a worker dies, and gives it up when it has killed several.
    """

    name = "dask"

    def __init__(self, address: str) -> None:
        self.address = address
        try:
            import distributed
        except ImportError:
            rule = "needs Dask: pip install 'flatland-light[dask]'"
            raise bad_input("--dask", address, rule) from None
        self._client = self._connected(distributed)
        self.slots = _AHEAD * max(1, sum(self._client.nthreads().values()))

    def _connected(self, distributed: Any) -> Any:
        try:
            return distributed.Client(self.address, timeout=_PATIENCE, set_as_default=False)
        except (OSError, ValueError, TimeoutError, ImportError) as error:
            rule = f"is no Dask scheduler that answers: {error}"
            raise InputError(str(bad_input("--dask", self.address, rule))) from None

    def open(self) -> Executor:
        if self._client.status != "running":
            raise EngineLostError(f"the Dask scheduler at {self.address} is gone")
        executor: Executor = self._client.get_executor(pure=False)
        return executor

    def close(self, executor: Executor, at_once: bool) -> None:
        executor.shutdown(wait=not at_once)

    def disconnect(self) -> None:
        self._client.close()
