"""A folder into which bags are recorded one after the other."""

from pathlib import Path

from cdp_ident.bag.metadata import METADATA_FILE
from cdp_ident.errors import OptionError


class WatchedFolder:
    """Tells which bags of a folder are complete and not taken yet."""

    def __init__(self, folder: Path) -> None:
        """Watch a folder; one that is not there yet is waited for.

        Raises:
            OptionError: there is something else of that name.
        """
        if folder.exists() and not folder.is_dir():
            raise OptionError(f"{folder} is not a folder: --watch takes the one that the recorder records into")
        self.folder = folder
        self._taken: set[Path] = set()

    def new(self) -> list[Path]:
        """Return the complete bags that have not been taken, the one that was completed first before the others.

        A bag is complete once it has its metadata, which whoever records writes last.
        """
        found = [(path.stat().st_mtime_ns, path.parent) for path in self.folder.glob(f"*/{METADATA_FILE}")]
        return [bag for _, bag in sorted(found) if bag not in self._taken]

    def take(self, bag: Path) -> None:
        """Do not return a bag any more."""
        self._taken.add(bag)
