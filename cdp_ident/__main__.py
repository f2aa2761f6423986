# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""`python3 -m cdp_ident NODE …`: the same as `ros2 run cdp_ident NODE …`, for people without ROS's command line."""

import sys

from cdp_ident.errors import CdpIdentError
from cdp_ident.executables import EXECUTABLES
from cdp_ident.start import start


def main() -> int:
    """Run the executable named by the first argument with the arguments after it."""
    usage = f"usage: python3 -m cdp_ident NODE …   where NODE is one of: {', '.join(sorted(EXECUTABLES))}"
    if len(sys.argv) < 2 or sys.argv[1] in ("-h", "--help"):
        print(f"{usage}\n\n`python3 -m cdp_ident NODE --help` tells what each one does.")
        return 0 if len(sys.argv) > 1 else CdpIdentError.exit_code
    name = sys.argv.pop(1)
    if name not in EXECUTABLES:
        print(f"cdp_ident: error: there is no node {name!r}; {usage}", file=sys.stderr)
        return CdpIdentError.exit_code
    sys.argv[0] = name
    return start(name)


if __name__ == "__main__":
    sys.exit(main())
