"""Tasks taken one by one, a few at work, results handed on as they come: the loop that engines with workers share."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable

from pipelines.engines.base import Done, Task


def keep_full(
    tasks: Iterable[Task],
    window: Callable[[], int],
    give: Callable[[Task], None],
    take: Callable[[bool], Done | None],
) -> Generator[Done, None, None]:
    """Yield every result, and keep up to window() tasks given and not yet taken back.

    give: starts a task. take(wait): a result; None where there is none yet and it should not wait. Results that are
    there go out before more tasks are fetched, since whoever makes the tasks may be slow. Only the caller's thread touches
    `tasks`.
    """
    coming = iter(tasks)
    more, given = True, 0
    while True:
        if more and given < window():
            task = next(coming, None)
            if task is None:
                more = False
            else:
                give(task)
                given += 1
        if not given:
            if more:
                continue
            return
        done = take(not (more and given < window()))
        if done is not None:
            given -= 1
            yield done
