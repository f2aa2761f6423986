"""The models that a report compares, as pictures name and colour them."""

from dataclasses import dataclass
from typing import Literal

from cdp_ident.report.figures.palette import Colour
from cdp_ident.report.schema import Section


@dataclass(frozen=True)
class Model:
    """One fitted model."""

    key: Literal["before", "after"]
    """Its key in `report.json`, and the name of its curves."""
    label: str

    @property
    def colour(self) -> Colour:
        """Its colour in every picture."""
        return self.key


def models(report: Section) -> list[Model]:
    """Return the paper's model and, where effects were found, the model with them."""
    before = Model("before", "before: the paper's model, fitted")
    return [before, Model("after", "after: with the effects found")] if report["effects"] else [before]
