"""Work spread over processes: joblib's on this machine, dask.distributed's on others. A killed one loses nothing."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Sequence
from typing import Any, Protocol, TypeVar

from joblib import Parallel, delayed
from joblib.externals.loky.process_executor import BrokenProcessPool

from stribeck.errors import InputError, StribeckError

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")
DEATHS = 3  # of processes in a row without a result between them: then it is the work that kills them
AHEAD = 2  # pieces of work that wait for each worker; their inputs are held in memory
WAIT = 30.0  # s, for a scheduler to answer and for workers to come back


class Farm(Protocol):
    """Does work on many keys, in any order.

    ``run(work, keys)`` gives ``(key, work(key))`` as they come in; `load` is called here, `work` elsewhere.
    """

    def run(self, work: Callable[[Any], V], load: Callable[[K], Any], keys: Sequence[K]) -> Iterator[tuple[K, V]]: ...  # noqa: D102


class Processes:
    """Processes on this machine.

    Parameters
    ----------
    jobs : int
        How many.
    """

    def __init__(self, jobs: int = 2) -> None:
        self.jobs = jobs

    def run(self, work: Callable[[Any], V], load: Callable[[K], Any], keys: Sequence[K]) -> Iterator[tuple[K, V]]:
        """Give ``(key, work(load(key)))`` as they are done; when a process dies, its keys are done again.

        Raises
        ------
        StribeckError
            When processes die again and again and nothing gets done.
        """
        left, deaths = list(keys), 0
        while left:
            try:
                pieces = (delayed(_keyed)(work, key, load(key)) for key in list(left))
                parallel = Parallel(n_jobs=self.jobs, return_as="generator_unordered", pre_dispatch=AHEAD * self.jobs)
                for key, value in parallel(pieces):
                    left.remove(key)
                    deaths = 0
                    yield key, value
            except BrokenProcessPool as error:
                deaths += 1
                if deaths >= DEATHS:
                    raise StribeckError(
                        "the processes die at their work", str(error), "see whether memory runs out; use fewer --jobs"
                    ) from error


class Cluster:
    """The workers of a dask.distributed scheduler, which need this package too, of the same version.

    Parameters
    ----------
    address : str
        Of the scheduler, such as ``tcp://10.0.0.5:8786``.
    """

    def __init__(self, address: str) -> None:
        self.address = address

    def run(self, work: Callable[[Any], V], load: Callable[[K], Any], keys: Sequence[K]) -> Iterator[tuple[K, V]]:
        """Give ``(key, work(load(key)))`` as they are done; the scheduler gives a dead worker's keys to others.

        Raises
        ------
        InputError
            When dask.distributed is missing or no scheduler answers.
        StribeckError
            When all workers are gone, or one key kills worker after worker.
        """
        client = self._client()
        try:
            yield from _submitted(client, work, load, list(keys))
        finally:
            client.close()

    def _client(self) -> Any:
        try:
            from distributed import Client
        except ImportError:
            raise InputError(
                "--cluster needs dask.distributed", "not installed", "pip install stribeck[cluster]"
            ) from None
        try:
            return Client(self.address, timeout=WAIT, set_as_default=False)
        except (OSError, ValueError) as error:
            raise InputError("--cluster: no scheduler answers", self.address, f"start one ({error})") from None


def _submitted(client: Any, work: Callable[[Any], V], load: Callable[[K], Any], keys: list[K]) -> Iterator[tuple[K, V]]:
    from distributed import KilledWorker, as_completed

    waiting, futures, pending = iter(keys), as_completed(), 0

    def submit() -> int:
        for key in waiting:
            futures.add(client.submit(_keyed, work, key, load(key), pure=False, retries=0))
            return 1
        return 0

    client.wait_for_workers(1, timeout=WAIT)
    for _ in range(AHEAD * max(1, sum(client.nthreads().values()))):
        pending += submit()
    while pending:
        future = next(futures)
        try:
            key, value = future.result()
        except KilledWorker as error:
            raise StribeckError(
                "a case kills worker after worker", str(error), "see whether memory runs out"
            ) from error
        pending += submit() - 1
        yield key, value


def _keyed(work: Callable[[Any], V], key: K, given: Any) -> tuple[K, V]:
    return key, work(given)
