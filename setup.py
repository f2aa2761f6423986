# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Build script of the ROS 2 package, called by colcon.

Building compiles the laws, with their derivatives, and the inner loops for this machine and user, beside all else, so
that the first run need not: about a minute of CPU time. Where that fails (numba is not installed when it is built), the
first run does it.
"""

import runpy
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

from setuptools import Command, find_packages, setup
from setuptools.command.build_py import build_py
from setuptools.command.develop import develop

NAME = "cdp_ident"
ROOT = Path(__file__).parent


def executables() -> list[str]:
    """Return an entry point for each executable of the package's table."""
    table = runpy.run_path(str(ROOT / NAME / "executables.py"))["EXECUTABLES"]
    return [f"{name} = {NAME}.start:{name}" for name in table]


def shared(folder: str) -> tuple[str, list[str]]:
    """Return a data_files entry that installs the files of a folder into the package's share directory."""
    return f"share/{NAME}/{folder}", sorted(str(path) for path in Path(folder).glob("*") if path.is_file())


def compiling(command: type[Command]) -> type[Command]:
    """Return a build command during which laws and inner loops are compiled."""

    def run(self: Command) -> None:
        nowhere = subprocess.DEVNULL
        loops = [sys.executable, "-m", f"{NAME}.pipeline.compile_ahead"]
        with ExitStack() as stack:
            for way in ([], ["backwards"]):  # for two cores
                stack.enter_context(
                    subprocess.Popen([*loops, *way], cwd=ROOT, stdin=nowhere, stdout=nowhere, stderr=nowhere)
                )
            command.run(self)

    return type(command.__name__, (command,), {"run": run})


setup(
    name=NAME,
    cmdclass={"build_py": compiling(build_py), "develop": compiling(develop)},
    version="0.8.13",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed", "demo/rig.yaml", "report/schema.md", "report/templates/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        *(shared(folder) for folder in ("config", "examples", "launch", "urdf")),
    ],
    # Kept equal to requirements.txt's names; ROS's own packages are not distributions that pip sees.
    install_requires=[
        "setuptools",
        "numpy",
        "scipy",
        "numba",
        "llvmlite",
        "pyyaml",
        "rich",
        "matplotlib",
        "jinja2",
        "rosbags",
        "mcap",
        "zstandard",
        "lz4",
        "jsonschema",
        "pyserial",
        "cobs",
    ],
    extras_require={"test": ["pytest", "hypothesis", "playwright"], "cluster": ["distributed"]},
    zip_safe=True,
    maintainer="cdp_ident maintainers",
    maintainer_email="maintainers@example.com",
    description="Identifies the physical parameters of a cart double pendulum from free-swing trials.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": executables(),
        "ament_copyright.license": [f"apache2_spdx = {NAME}.spdx_header"],
    },
)
