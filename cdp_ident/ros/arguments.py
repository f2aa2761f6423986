"""What of a node's command line is ROS's, and what the node's own."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path


def split_arguments(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return a node's own arguments, and what stands between `--ros-args` and `--`, however often.

    ROS is given nothing but its own: a path among the others need not be UTF-8, as all of ROS's texts are.
    """
    own: list[str] = []
    of_ros: list[str] = []
    inside = False
    for argument in arguments:
        if argument == "--ros-args" or (inside and argument == "--"):
            inside = argument == "--ros-args"
        else:
            (of_ros if inside else own).append(argument)
    return own, of_ros


def parameter_files(of_ros: Sequence[str]) -> list[Path]:
    """Return the files that ROS's arguments give parameters in."""
    return [Path(value) for option, value in pairwise(of_ros) if option == "--params-file"]
