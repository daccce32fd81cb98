"""Trials played on a Dask cluster, for studies too large for one machine."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from ppinfer.studies import Trial
from ppsim.errors import SimulationError

if TYPE_CHECKING:
    from ppsim.study import Study

# OMPL draws from one generator a process: trials that threads of a worker play at the same time would mix their draws
_ONE_AT_A_TIME = threading.Lock()
_CONNECT_WITHIN_S = 10
_TRIALS_A_THREAD = 4


def simulate_on_cluster(study: Study, indices: Sequence[int], address: str) -> Iterator[Trial]:
    """Yield trials in the order of their indices, played by the workers of a Dask cluster.

    Parameters
    ----------
    study : Study
        What to simulate; workers must be able to import it, so ppinfer is to be installed there in the same version.
    indices : sequence of int
        Which trials.
    address : str
        Of the scheduler, as ``tcp://host:8786``.

    Raises
    ------
    SimulationError
        If the extra is not installed, nobody answers at the address, there are no workers, or one of them has another
        version of ppinfer.
    """
    try:
        import distributed
    except ImportError as error:
        raise SimulationError(
            "a cluster needs the package distributed: pip install 'ppinfer[cluster]'"
        ) from error
    try:
        connect: Any = distributed.Client
        client = connect(address, timeout=_CONNECT_WITHIN_S, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise SimulationError(f"no Dask scheduler answers at {address}: {error}") from error
    with client:
        _check_workers(client, address)
        ahead = _TRIALS_A_THREAD * max(1, sum(client.nthreads().values()))
        waiting: deque[Any] = deque()
        # only so many at a time: results wait here until those before them have come
        for index in indices:
            waiting.append(client.submit(_play, study, index, pure=False))
            if len(waiting) > ahead:
                yield _result(waiting.popleft(), address)
        while waiting:
            yield _result(waiting.popleft(), address)


def _result(future: Any, address: str) -> Trial:
    from distributed import KilledWorker
    from distributed.client import FutureCancelledError

    try:
        trial: Trial = future.result()
    except (FutureCancelledError, KilledWorker) as error:
        raise SimulationError(
            f"the Dask cluster at {address} was lost: {error}; trials that ended are recorded: go on with resume"
        ) from error
    return trial


def _check_workers(client: Any, address: str) -> None:
    from ppinfer import __version__

    versions: dict[str, str] = client.run(_version)
    if not versions:
        raise SimulationError(
            f"the Dask cluster at {address} has no workers; start some: dask worker {address}"
        )
    other = {worker: version for worker, version in versions.items() if version != __version__}
    if other:
        worker, version = next(iter(other.items()))
        raise SimulationError(
            f"worker {worker} has ppinfer {version}, this is {__version__}; install the same"
        )


def _version() -> str:
    from ppinfer import __version__

    return __version__


def _play(study: Study, index: int) -> Trial:
    with _ONE_AT_A_TIME:
        return study.trial(index)
