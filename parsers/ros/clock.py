"""What the readers of ROS 1 and ROS 2 bags say of their stamps."""

from __future__ import annotations

from parsers.ros.stamps import StampChooser


class BagClock:
    """The clock of `parsers.importer.LogReader`, for a reader that chooses its stamps. wall_clock: they count from 1970."""

    wall_clock: bool
    chooser: StampChooser

    @property
    def clock(self) -> str:
        """Which clock the stamps are from."""
        return self.chooser.clock

    @property
    def absolute(self) -> bool:
        """Whether stamps count from 1970: not in bags of simulated time."""
        return self.wall_clock

    @property
    def start_utc_ns(self) -> int | None:
        """Not needed: stamps are absolute."""
        return None
