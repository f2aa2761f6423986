"""How messages name an option: as the user would have to write it."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Wording:
    """Names options as keys of a parameter file by default."""

    prefix: str = ""
    """What stands before an option's name."""
    separator: str = ": "
    """What stands between an option and its value."""
    word_break: str = "_"
    """What parts the words of a name."""
    names: Mapping[str, str] = field(default_factory=dict)
    """Options that are called differently."""
    insist: str = "conventions: warn takes the data all the same"
    """How to get one's way."""

    def name(self, option: str) -> str:
        """Return what an option of `TrialOptions` is called."""
        return self.prefix + self.names.get(option, option).replace("_", self.word_break)

    def setting(self, option: str, value: object) -> str:
        """Return how it is set."""
        return f"{self.name(option)}{self.separator}{value}"


KEYS = Wording()
