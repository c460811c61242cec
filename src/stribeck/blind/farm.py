"""Work spread over processes: joblib's on this machine, dask.distributed's on others. A killed one loses nothing."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Sequence
from typing import Any, Protocol, TypeVar

from joblib import Parallel, delayed
from joblib.externals.loky.process_executor import BrokenProcessPool

from stribeck.errors import InputError, StribeckError

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")
DEATHS = 3  # of processes at the same key, alone: then it is the key that kills them
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
        How many; with one the work is done in this very process, and ends with it.
    """

    def __init__(self, jobs: int = 2) -> None:
        self.jobs = jobs

    def run(self, work: Callable[[Any], V], load: Callable[[K], Any], keys: Sequence[K]) -> Iterator[tuple[K, V]]:
        """Give ``(key, work(load(key)))`` as they are done; when a process dies, its keys are done again.

        Whatever ran then is suspect and comes last, one by one, so that a key that kills holds up no other.

        Raises
        ------
        StribeckError
            When all else is done, and a key has killed its process three times.
        """
        left, suspects = list(keys), list[K]()
        while left:
            running: list[K] = []
            try:
                for key, value in self._parallel(work, _noted(load, running), left):
                    running.remove(key)
                    left.remove(key)
                    yield key, value
            except BrokenProcessPool:
                suspects += running
                left = [key for key in left if key not in running]
        deadly = []
        for key in suspects:
            pair = self._alone(work, load, key)
            if pair is None:
                deadly.append(str(key))
            else:
                yield pair
        if deadly:
            what = "work kills the process that does it"
            raise StribeckError(what, ", ".join(deadly), "see whether memory runs out; all else is done")

    def _alone(self, work: Callable[[Any], V], load: Callable[[K], Any], key: K) -> tuple[K, V] | None:
        for _ in range(DEATHS):
            try:
                return next(self._parallel(work, load, [key]))
            except BrokenProcessPool:
                continue
        return None

    def _parallel(self, work: Callable[[Any], V], load: Callable[[K], Any], keys: Sequence[K]) -> Iterator[tuple[K, V]]:
        pieces = (delayed(_keyed)(work, key, load(key)) for key in list(keys))
        parallel = Parallel(n_jobs=self.jobs, return_as="generator_unordered", pre_dispatch=AHEAD * self.jobs)
        yield from parallel(pieces)


def _noted(load: Callable[[K], Any], running: list[K]) -> Callable[[K], Any]:
    """Return `load` that also notes for which keys it was called."""

    def noted(key: K) -> Any:
        running.append(key)
        return load(key)

    return noted


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

    waiting, futures, pending = iter(keys), as_completed([], loop=client.loop), 0

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
