# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Both codecs, for whatever must hold with either."""

import pytest

from cdp_ident.rig.protocol import CODECS


@pytest.fixture(scope="session", params=CODECS)
def codec(request):
    """One codec after the other."""
    return CODECS[request.param]()
