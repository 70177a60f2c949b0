"""Keep the last result until its inputs change."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, TypeVar

T = TypeVar("T")
_PLAIN = (int, float, str, bytes, bool, type(None))


def same(a: Any, b: Any) -> bool:
    """Whether two keys mean the same: plain values by ==, tuples part by part, everything else by identity.

    Fabrics, lights, meshes and arrays are frozen here, so the same object is the same content.
    """
    if a is b:
        return True
    if isinstance(a, _PLAIN) and isinstance(b, _PLAIN):
        return a == b
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(map(same, a, b))
    return False


class Last(Generic[T]):
    """One kept value and the key it was made for.

    `frees`: it is an object on the GPU, which is released before another is made
    """

    def __init__(self, frees: bool = False) -> None:
        self._frees = frees
        self._key: tuple | None = None
        self._value: T | None = None

    def get(self, make: Callable[[], T], *key: Any) -> T:
        """The value for a key: the kept one while the key stays the same, else what `make` returns."""
        if self.changes(*key):
            self._key = None  # if `make` fails, the next call tries again
            if self._frees:
                self.release()
            self._value = make()
            self._key = key
        return self._value  # type: ignore[return-value]

    def changes(self, *key: Any) -> bool:
        """Whether a key differs from the last one; it is the last one from now on."""
        before, self._key = self._key, key
        return before is None or not same(before, key)

    @property
    def value(self) -> T | None:
        """The kept value; None before the first."""
        return self._value

    @property
    def key(self) -> tuple | None:
        """The key of the kept value; None before the first, and after `forget`."""
        return self._key

    def forget(self) -> None:
        """Make the next key a new one."""
        self._key = None

    def release(self) -> None:
        """Free what is kept on the GPU."""
        if self._value is not None:
            self._value.release()  # type: ignore[attr-defined]
        self._key = self._value = None
