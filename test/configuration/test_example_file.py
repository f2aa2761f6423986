# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""config/identify.yaml shows every key as it is."""

import re
from pathlib import Path

import pytest

from cdp_ident.configuration.keys import KEYS
from cdp_ident.configuration.parameter_file import read_parameter_file
from cdp_ident.configuration.settings import Settings

FILE = Path(__file__).parents[2] / "config/identify.yaml"
TEXT = FILE.read_text()


def test_the_file_changes_nothing():
    assert Settings.of(read_parameter_file(FILE, "identify").taken()).values() == Settings.of({}).values()


def test_it_sets_exactly_the_keys_whose_default_depends_on_nothing():
    depends = ("lower.", "upper.", "known.", "known_std.", "search.")
    fixed = {name for name in KEYS if not name.startswith(depends)}
    assert set(read_parameter_file(FILE, "identify").taken()) == fixed


def test_all_other_keys_are_there_commented_out_with_their_defaults(tmp_path):
    # Taking away the "# " of what is a key or a group of them makes them active.
    active = re.sub(r"(?m)^    # ((?:  )?\w+:(?: [\w.…]+)?(?: +#.*)?)$", r"    \1", TEXT).replace("…", "null")
    (tmp_path / "all.yaml").write_text(active)
    found = read_parameter_file(tmp_path / "all.yaml", "identify").taken()
    assert set(found) == set(KEYS)
    for key in KEYS.values():
        assert found[key.name] == (key.value if not isinstance(key.value, float) else pytest.approx(key.value))


@pytest.mark.parametrize("key", [key for key in KEYS.values() if key.unit], ids=lambda key: key.name)
def test_units_stand_beside_the_keys(key):
    group, _, name = key.name.rpartition(".")
    section = TEXT[TEXT.index(f"{group}:\n") :] if group else TEXT
    line = re.search(rf"(?m)(?:^.*\n)?^[ #]*{name}:.*$", section)
    assert f"[{key.unit}]" in line[0]
