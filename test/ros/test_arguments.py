"""A node's command line is shared out between ROS and the node."""

from pathlib import Path

import pytest

from cdp_ident.ros.arguments import parameter_files, split_arguments


@pytest.mark.parametrize(
    ("arguments", "own", "of_ros"),
    [
        ([], [], []),
        (["--bag", "one"], ["--bag", "one"], []),
        (["--bag", "\udcff", "--ros-args", "-p", "a:=1"], ["--bag", "\udcff"], ["-p", "a:=1"]),
        (["--ros-args", "-p", "a:=1", "--", "--once"], ["--once"], ["-p", "a:=1"]),
        (["--ros-args", "-p", "a:=1", "--ros-args", "-p", "b:=2"], [], ["-p", "a:=1", "-p", "b:=2"]),
        (["one", "--", "two"], ["one", "--", "two"], []),
    ],
)
def test_ros_is_given_what_stands_behind_its_mark(arguments: list[str], own: list[str], of_ros: list[str]) -> None:
    assert split_arguments(arguments) == (own, of_ros)


def test_files_with_parameters_are_told() -> None:
    assert parameter_files(["--params-file", "a.yaml", "-p", "b:=1", "--params-file", "c.yaml"]) == [
        Path("a.yaml"),
        Path("c.yaml"),
    ]
