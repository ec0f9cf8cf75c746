"""How often a world was changed, by which those who share it see that another has."""


class Changes:
    """A count of the calls that moved something in a world, or gave it another shape or colour."""

    def __init__(self) -> None:
        self.count = 0

    def note(self) -> None:
        """One more."""
        self.count += 1
