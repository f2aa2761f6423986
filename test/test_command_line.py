"""Every executable answers its command line in the same way."""

import importlib

import pytest

from cdp_ident.executables import EXECUTABLES

MAINS = [pytest.param(importlib.import_module(module).main, id=name) for name, module in EXECUTABLES.items()]


@pytest.mark.parametrize("main", MAINS)
def test_an_unknown_option_is_one_line_and_exit_code_2(main, capsys):
    assert main(["--no-such-option"]) == 2
    out, err = capsys.readouterr()
    assert not out
    assert err.count("\n") == 1
    assert "--help tells more" in err


@pytest.mark.parametrize("main", MAINS)
def test_help_is_printed_and_exits_0(main, capsys):
    with pytest.raises(SystemExit) as end:
        main(["--help"])
    assert end.value.code == 0
    assert capsys.readouterr().out.startswith("usage: ")
