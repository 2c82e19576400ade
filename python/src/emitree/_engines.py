"""What `executor` stands for: a pool of `concurrent.futures`, a dask client, or Ray."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import Executor, Future
from types import ModuleType
from typing import Any, Protocol
from weakref import WeakSet

from emitree._native import SceneError


class Engine(Protocol):
    """Workers that call functions."""

    #: What its time of a call is known by, for later renderings.
    identity: Any

    def workers(self) -> int:
        """How many calls they work on at once, as far as it is known."""

    def submit(self, work: Callable[..., Any], function: Any, *arguments: Any) -> Future[Any]:
        """The result to come of some work; `function` is the same for many calls."""

    def submit_again(self, work: Callable[..., Any], function: Any, *arguments: Any) -> Future[Any]:
        """The same of work that is late: for another worker, as far as one can be chosen."""

    def result(self, future: Future[Any]) -> Any:
        """The result of a future that is done; raises the exception of the function."""

    def cancel(self, futures: Iterable[Future[Any]]) -> None:
        """Calls off what is not needed any more, as far as the workers permit it."""


class Pool:
    """A `concurrent.futures.Executor`: threads, processes, `mpi4py.futures`, that of a client."""

    def __init__(self, executor: Executor) -> None:
        self.executor = executor
        self.identity = executor

    def workers(self) -> int:
        """The threads of a cluster, the workers of a pool, or else the processors."""
        client = getattr(self.executor, "_client", None)
        if client is not None and hasattr(client, "nthreads"):
            return threads_of(client)
        workers = getattr(self.executor, "_max_workers", None)
        return workers if isinstance(workers, int) and workers > 0 else os.cpu_count() or 1

    def submit(self, work: Callable[..., Any], function: Any, *arguments: Any) -> Future[Any]:
        """The result to come."""
        return self.executor.submit(work, function, *arguments)

    def submit_again(self, work: Callable[..., Any], function: Any, *arguments: Any) -> Future[Any]:
        """The result to come, of any worker."""
        return self.submit(work, function, *arguments)

    def result(self, future: Future[Any]) -> Any:
        """The result."""
        return future.result()

    def cancel(self, futures: Iterable[Future[Any]]) -> None:
        """Calls off what no worker has begun."""
        for future in futures:
            future.cancel()


class Dask(Pool):
    """A dask `Client`: a call that was lost with its worker is repeated by the scheduler."""

    def __init__(self, client: Any) -> None:
        if getattr(client, "asynchronous", False):
            raise SceneError("`executor` is an asynchronous dask client: expected another one")
        # Rates are the same each time, but a pure function would be called once for equal arrays.
        super().__init__(client.get_executor(pure=False))
        self.client = self.identity = client
        #: Futures of other executors than the present one.
        self.again: WeakSet[Future[Any]] = WeakSet()

    def workers(self) -> int:
        """The threads of all workers that are there now."""
        return threads_of(self.client)

    def submit_again(self, work: Callable[..., Any], function: Any, *arguments: Any) -> Future[Any]:
        """The result to come, of a worker with the fewest calls: not of one that stalls."""
        calls = {worker: len(keys) for worker, keys in self.client.processing().items()}
        fewest = min(calls.values(), default=0)
        workers = [worker for worker, count in calls.items() if count == fewest]
        choice = {"workers": workers, "allow_other_workers": True} if workers else {}
        executor = self.client.get_executor(pure=False, **choice)
        future: Future[Any] = executor.submit(work, function, *arguments)
        self.again.add(future)
        return future

    def cancel(self, futures: Iterable[Future[Any]]) -> None:
        """Calls off what no worker has begun."""
        waiting = [future for future in futures if not future.done()]
        if len(waiting) <= 1:
            return super().cancel(waiting)
        super().cancel([future for future in waiting if future in self.again])
        # All in one message to the scheduler.
        self.executor.shutdown(wait=False)
        self.executor = self.client.get_executor(pure=False)


class Ray:
    """The cluster that Ray is connected to: a call that was lost with its worker is repeated."""

    def __init__(self, ray: Any) -> None:
        if not ray.is_initialized():
            raise SceneError(
                "`executor` is ray, which is not connected: expected `ray.init()` before"
            )
        self.ray = self.identity = ray
        self.references: dict[Future[Any], Any] = {}
        #: What workers do, as Ray knows it.
        self.remote: dict[Callable[..., Any], Any] = {}
        #: Functions are sent to each machine once: by their identity, with themselves.
        self.stored: dict[int, tuple[Any, Any]] = {}

    def workers(self) -> int:
        """The processors of the cluster."""
        return max(1, int(self.ray.cluster_resources().get("CPU", 1)))

    def submit(self, work: Callable[..., Any], function: Any, *arguments: Any) -> Future[Any]:
        """The result to come."""
        if id(function) not in self.stored:
            self.stored[id(function)] = function, self.ray.put(function)
        if work not in self.remote:
            self.remote[work] = self.ray.remote(work).options(name="emitree")
        reference = self.remote[work].remote(self.stored[id(function)][1], *arguments)
        future: Future[Any] = reference.future()
        self.references[future] = reference
        return future

    def submit_again(self, work: Callable[..., Any], function: Any, *arguments: Any) -> Future[Any]:
        """The result to come: Ray gives it to a worker that is free."""
        return self.submit(work, function, *arguments)

    def result(self, future: Future[Any]) -> Any:
        """The result; exceptions of the function are raised as they were in the worker."""
        self.references.pop(future, None)
        try:
            return future.result()
        except self.ray.exceptions.RayTaskError as error:
            cause = getattr(error, "cause", None)
            if not isinstance(cause, BaseException):
                raise
            raise cause from error

    def cancel(self, futures: Iterable[Future[Any]]) -> None:
        """Calls off all, also what a worker is doing."""
        for future in futures:
            reference = self.references.pop(future, None)
            if reference is not None and not future.done():
                self.ray.cancel(reference)


def threads_of(client: Any) -> int:
    """The threads of all workers of a dask client; 1 as long as there are none."""
    return max(1, sum(client.nthreads().values()))


def engine_of(executor: Any) -> Engine:
    """What `executor` stands for; raises `SceneError` if it has no workers."""
    if isinstance(executor, ModuleType) and executor.__name__ == "ray":
        return Ray(executor)
    if hasattr(executor, "get_executor"):
        return Dask(executor)
    if not callable(getattr(executor, "submit", None)) or isinstance(executor, type):
        raise SceneError(
            f"`executor` is {executor!r}: expected a concurrent.futures.Executor, which has "
            "`submit`, a dask.distributed.Client, or the module ray"
        )
    return Pool(executor)
