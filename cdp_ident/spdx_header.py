# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The header of this package's files, which `ament_copyright` asks for as for any licence: its entry point in setup.py.

That is how a licence which it does not know is told to it; of its own, the one for Apache-2.0 has thirteen lines.
"""

name = "Apache License, Version 2.0, by its SPDX identifier"
spdx = "Apache-2.0"
file_headers = ("{copyright}\nSPDX-License-Identifier: Apache-2.0\n",)
license_files: tuple[str, ...] = ()
"""It knows the text of LICENSE."""
contributing_files = ("Contributions are licensed under Apache-2.0.",)
