"""Progress of long calls."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

from ._extras import needed

Progress: TypeAlias = Callable[[str, int, int], object]
"""Hears of a step under way: its name, units done, units in all."""


class _Bar:
    """A bar by tqdm, one for each step."""

    def __init__(self) -> None:
        self._make: Any = needed("tqdm.auto", "progress", "progress=True").tqdm
        self._bar: Any = None
        self._step = ("", 0)

    def __call__(self, step: str, done: int, total: int) -> None:
        if self._bar is None or self._step != (step, total):
            self.close()
            self._step = (step, total)
            self._bar = self._make(total=total, desc=step, unit_scale=True, leave=False)
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()


def listener(progress: bool | Progress | None) -> Progress | None:
    """The function to call: the caller's own, a bar for ``True``, or none."""
    if progress is None or progress is False:
        return None
    if progress is True:
        return _Bar()
    if not callable(progress):
        raise TypeError(
            "progress: expected True or a function of step, done and total, "
            f"found {type(progress).__name__}"
        )
    return progress
