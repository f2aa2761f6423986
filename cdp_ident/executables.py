# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The executables of the package: the one table that setup.py installs and `python3 -m cdp_ident` runs."""

EXECUTABLES = {
    "driver": "cdp_ident.nodes.driver",
    "emulator": "cdp_ident.nodes.emulator",
    "identify": "cdp_ident.nodes.identify",
    "recorder": "cdp_ident.nodes.recorder",
    "simulator": "cdp_ident.nodes.simulator",
    "compare": "cdp_ident.commands.compare",
    "compare_searches": "cdp_ident.commands.compare_searches",
    "import_csv": "cdp_ident.commands.import_csv",
    "linearize": "cdp_ident.commands.linearize",
    "suggest": "cdp_ident.commands.suggest",
    "report": "cdp_ident.commands.report",
    "survey": "cdp_ident.commands.survey",
    "demo": "cdp_ident.demo.demo",
}
"""The module of each executable, by its name; the module's `main` runs it."""
