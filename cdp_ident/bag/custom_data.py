"""What a recorder wrote about a trial into the `metadata.yaml` of its bag."""

from pathlib import Path

from cdp_ident.bag.metadata import read_information


def read_custom_data(bag: Path) -> tuple[dict[str, str], str]:
    """Return the custom data of a bag's metadata, and in words why they could not be read, if they are there."""
    information, problem = read_information(bag)
    custom = information.get("custom_data")
    if not isinstance(custom, dict):
        return {}, problem
    return {key: value for key, value in custom.items() if isinstance(key, str) and isinstance(value, str)}, problem
