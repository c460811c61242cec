"""Work spread over processes: joblib's on this machine, dask.distributed's on others. A killed one loses nothing."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Sequence
from itertools import islice
from queue import Empty, Queue
from socket import create_connection
from typing import Any, Protocol, TypeVar

from joblib import Parallel, delayed
from joblib.externals.loky.process_executor import BrokenProcessPool

from stribeck.errors import InputError, StribeckError

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")
DEATHS = 3  # of processes at the same key, alone: then it is the key that kills them
AHEAD = 2  # pieces of work that wait for each worker; their inputs are held in memory
LOOK = 10.0  # s, after which to see whether there are workers left
WAIT = 30.0  # s, for a scheduler to answer and for workers to come back


class Farm(Protocol):
    """Does work on many keys, in any order."""

    def run(self, work: Callable[[Any], V], load: Callable[[K], Any], keys: Sequence[K]) -> Iterator[tuple[K, V]]:
        """Give ``(key, work(load(key)))`` as they come in; `load` is called here, `work` elsewhere."""


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

    def check(self) -> None:
        """Raise `InputError` when dask.distributed is missing or nothing listens at the address.

        A client that finds nobody leaves half of itself behind, which complains at the end of the program.
        """
        try:
            import distributed.comm.addressing as addressing
        except ImportError:
            raise InputError(
                "--cluster needs dask.distributed", "not installed", "pip install stribeck[cluster]"
            ) from None
        try:
            with create_connection(addressing.get_address_host_port(self.address), timeout=WAIT):
                pass
        except (OSError, ValueError) as error:
            raise self._silent(error) from None

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
        self.check()
        from distributed import Client

        try:
            return Client(self.address, timeout=WAIT, set_as_default=False)
        except (OSError, ValueError) as error:
            raise self._silent(error) from None

    def _silent(self, error: Exception) -> InputError:
        return InputError("--cluster: no scheduler answers", self.address, f"start one ({error})")


def _submitted(client: Any, work: Callable[[Any], V], load: Callable[[K], Any], keys: list[K]) -> Iterator[tuple[K, V]]:
    """Keep a few pieces of work waiting for every worker; inputs are loaded as they are needed."""
    waiting, done = iter(keys), Queue[Any]()
    running = set[Any]()  # a future that nobody holds is work that nobody wants

    def top_up(count: int) -> None:
        for key in islice(waiting, count):
            future = client.submit(_keyed, work, key, load(key), pure=False)
            running.add(future)
            future.add_done_callback(done.put)

    top_up(AHEAD * _threads(client))
    while running:
        try:
            future = done.get(timeout=LOOK)
        except Empty:  # work may take long; without workers it would take for ever
            _threads(client)
            continue
        running.remove(future)
        yield _result(future)
        top_up(1)


def _threads(client: Any) -> int:
    """Return the number of threads of all workers; wait for some to come, or come back."""
    try:
        client.wait_for_workers(1, timeout=WAIT)
    except TimeoutError:
        raise StribeckError("the cluster has no workers", "", "start some; the same command goes on") from None
    except Exception as error:  # of many kinds, when a connection breaks
        raise _gone(error) from error
    return max(1, int(sum(client.nthreads().values())))


def _result(future: Any) -> Any:
    from distributed import KilledWorker

    try:
        return future.result()
    except KilledWorker as error:
        raise StribeckError("work kills worker after worker", str(error), "see whether memory runs out") from error
    except Exception as error:  # the work itself turns errors into answers
        raise _gone(error) from error


def _gone(error: BaseException) -> StribeckError:
    what = f"the cluster does not answer any more ({type(error).__name__})"
    return StribeckError(what, str(error), "start it again; the same command goes on")


def _keyed(work: Callable[[Any], V], key: K, given: Any) -> tuple[K, V]:
    return key, work(given)
