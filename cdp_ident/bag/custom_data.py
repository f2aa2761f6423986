"""What a recorder wrote about a trial into the `metadata.yaml` of its bag."""

from pathlib import Path
from typing import Any

from cdp_ident.bag.metadata import METADATA_FILE
from cdp_ident.yaml_file import read_yaml


def read_custom_data(bag: Path) -> tuple[dict[str, str], str]:
    """Return the custom data of a bag's metadata, and in words why they could not be read, if they are there.

    A bag without metadata has none. Of a single file those of its folder are taken.
    """
    path = (bag if bag.is_dir() else bag.parent) / METADATA_FILE
    if not path.is_file():
        return {}, ""
    try:
        content: Any = read_yaml(path)
    except (OSError, ValueError) as error:
        return {}, f"{METADATA_FILE} cannot be read, so what it says of the trial is not known: {error}"
    information = content.get("rosbag2_bagfile_information") if isinstance(content, dict) else None
    custom = information.get("custom_data") if isinstance(information, dict) else None
    if not isinstance(custom, dict):
        return {}, ""
    return {key: value for key, value in custom.items() if isinstance(key, str) and isinstance(value, str)}, ""
