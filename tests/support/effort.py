"""How much the tests try: a sample of each kind, or all with ``--every-form``."""


class Effort:
    """``every`` is set before any test is collected."""

    every = False

    def sample(self, count: int, sampled: int) -> int:
        """Return ``count`` with ``--every-form``, else ``sampled``."""
        return count if self.every else sampled


EFFORT = Effort()
