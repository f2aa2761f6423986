# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Make a bag of a CSV file: `import_csv CSV --out DIR …`."""

from cdp_ident.command_line import entry_point
from cdp_ident.commands._csv_arguments import parse
from cdp_ident.start import loading


@entry_point
def main(arguments: list[str]) -> int:
    """Make a bag of a CSV file."""
    options = parse(arguments)
    with loading("import_csv"):
        from cdp_ident.commands._csv_bag import make_bag
    make_bag(options, arguments)
    return 0
