"""Frame times as they are, and what gives way when they are too long."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vrlf.gpu.window import monitors

_KEPT = 240
_DEFAULT_RATE_HZ = 60.0
# A frame counts as late from this many periods on; vsync makes whole ones.
_LATE = 1.5
# Of a period: above this something gives way, below that it comes back.
_TOO_MUCH, _PLENTY = 0.9, 0.45
_PATIENCE = 20
SHARES: tuple[float, ...] = (1.0, 0.5, 0.25, 0.125)


def refresh_hz(monitor: int) -> float:
    """How often a monitor shows a frame; 60 where it does not say."""
    found = monitors()
    rate_hz = found[min(monitor, len(found) - 1)].rate_hz if found else 0.0
    return rate_hz or _DEFAULT_RATE_HZ


@dataclass(frozen=True)
class Effort:
    """What a frame may cost.

    Attributes
    ----------
    share : float
        Of the rays and steps that were asked for.
    """

    share: float = 1.0

    def of(self, count: int, least: int = 1) -> int:
        """So many of the rays or steps that were asked for."""
        return max(min(least, count), round(count * self.share))


class FrameClock:
    """Intervals between frames that follow one another, and what was dropped."""

    def __init__(self, period_ms: float) -> None:
        self.period_ms = period_ms
        self.intervals_ms: deque[float] = deque(maxlen=_KEPT)
        self.dropped = 0
        self.frames = 0
        self._last_s: float | None = None

    def pause(self) -> None:
        """What comes next does not follow: the window rested."""
        self._last_s = None

    def tick(self, now_s: float) -> None:
        """A frame was shown."""
        self.frames += 1
        if self._last_s is not None:
            interval_ms = 1e3 * (now_s - self._last_s)
            self.intervals_ms.append(interval_ms)
            if interval_ms > _LATE * self.period_ms:
                self.dropped += round(interval_ms / self.period_ms) - 1
        self._last_s = now_s

    def percentile_ms(self, percent: float) -> float:
        """Of the last frames; 0 before there are any."""
        return float(np.percentile(self.intervals_ms, percent)) if self.intervals_ms else 0.0


class Pacer:
    """Lets the effort give way when the work of frames overruns the display's period.

    Attributes
    ----------
    effort : Effort
    """

    def __init__(self, period_ms: float) -> None:
        self._period_ms = period_ms
        self._level = 0
        self._over = self._under = 0

    @property
    def effort(self) -> Effort:
        """As it stands."""
        return Effort(SHARES[self._level])

    @property
    def has_given_way(self) -> bool:
        """Whether frames cost less than was asked for."""
        return self._level > 0

    def spent(self, work_ms: float) -> bool:
        """Take note of a frame's own work; whether the effort changed.

        It gives way after some frames in a row that took too long, and comes back after six
        times as many that took little: a level that is just too dear is not tried at each turn.
        """
        self._over = self._over + 1 if work_ms > _TOO_MUCH * self._period_ms else 0
        self._under = self._under + 1 if work_ms < _PLENTY * self._period_ms else 0
        if self._over >= _PATIENCE and self._level < len(SHARES) - 1:
            self._level, self._over = self._level + 1, 0
            return True
        if self._under >= 6 * _PATIENCE and self._level > 0:
            self._level, self._under = self._level - 1, 0
            return True
        return False


def told(clock: FrameClock, steps_ms: dict[str, float]) -> Sequence[str]:
    """Frame times in words."""
    lines = [
        f"{clock.percentile_ms(50):.1f} ms a frame (99 %: {clock.percentile_ms(99):.1f}), "
        f"budget {clock.period_ms:.1f}, dropped {clock.dropped} of {clock.frames}"
    ]
    lines += [f"{step} {spent:.2f} ms" for step, spent in steps_ms.items()]
    return lines
