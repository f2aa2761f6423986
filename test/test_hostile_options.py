# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whatever an option or a parameter says, an executable ends with an exit code, and bad input is told in one line."""

import importlib
import os
import re
import shutil
import signal
import threading
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from cdp_ident.command_line import ArgumentParser
from cdp_ident.configuration.fitted_model import fitted_yaml
from cdp_ident.executables import EXECUTABLES
from cdp_ident.model.motions import simulate
from cdp_ident.model.parameters import NOMINAL, physical_coefficients
from cdp_ident.report.report_file import read_report
from scenarios.clean_bags import write_clean_bags

pytestmark = pytest.mark.long

ROOT = Path(__file__).parents[1]
NODES = ("driver", "recorder", "emulator", "simulator")
COMMANDS = tuple(name for name in EXECUTABLES if name not in (*NODES, "demo"))  # which asks for two files alone
LONG = "a" * 300
TEXTS = st.one_of(
    st.sampled_from([
        "", " ", "a b", "~", "~nobody/at/home", "..", ".", "nan", "inf", "-inf", "-1", "0", "1e308", "1e-308",
        "9" * 5000, "9e9", "9999-12-31T23:59:59Z", LONG, f"{LONG}/b", "\udcff.yaml", "\x1b[31mred", "a\0b",
        "/dev/null", "/dev/full", "/proc/self/mem", "/nowhere/at/all", "a=1,nan", "outer=1e308,1e308", "{}", "[1",
        "-", "--", "😀", "\u202ereversed",
    ]),
    st.text(max_size=20).filter(lambda text: not text.startswith("/")),  # tests may run as who may write everywhere
    st.floats().map(repr),
    st.integers().map(str),
)  # fmt: skip


class _ReadError(Exception):
    pass


def options_of(name):
    """Return the options of an executable that take a value, as its parser has them."""
    found = []

    def read(parser, arguments, namespace=None):
        found.extend(a.option_strings[0] for a in parser._actions if a.option_strings and a.nargs != 0)
        raise _ReadError

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ArgumentParser, "parse_args", read)
        with suppress(_ReadError):
            importlib.import_module(EXECUTABLES[name]).main([])
    return found


@pytest.fixture(scope="module")
def place(report_folder, tmp_path_factory):
    """A folder with all that executables need, in which they run."""
    folder = tmp_path_factory.mktemp("a") / "b" / "c"
    shutil.copytree(report_folder, folder / "report")
    write_clean_bags(folder, swing=6.0)
    (folder / "fitted.yaml").write_text(fitted_yaml(read_report(report_folder / "report.json")))
    time = np.arange(600) / 200.0
    theta = simulate(physical_coefficients(dict(NOMINAL)), np.array([2.0, 2.5, 0.0, 0.0]), time)[:, :2]
    rows = "\n".join(f"{t},{a},{b}" for t, (a, b) in zip(time, theta, strict=True))
    (folder / "swing.csv").write_text(f"t,a,b\n{rows}\n")
    (folder / "empty").mkdir()
    before = Path.cwd()
    os.chdir(folder)
    yield folder
    os.chdir(before)


USUAL = {
    "identify": ["--once", "--bag", "empty"],
    "compare": ["report", "report"],
    "compare_searches": ["--bag", "empty"],
    "import_csv": ["swing.csv", "--outer-angle", "absolute", "--angle-unit", "rad"],
    "linearize": ["fitted.yaml"],
    "suggest": ["report", "--spacing", "90", "--for", "c1"],
    "report": ["report"],
    "survey": ["empty"],
}
CASES = [(name, option) for name in COMMANDS for option in options_of(name)]


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(case=st.sampled_from(CASES), text=TEXTS)
@example(("import_csv", "--start-stamp"), "9e9")
@example(("import_csv", "--start-stamp"), "9999-12-31T23:59:59Z")
@example(("import_csv", "--start-stamp"), "0001-01-01T00:00:00+14:00")
@example(("import_csv", "--time"), "9" * 5000)
@example(("import_csv", "--out"), LONG)
@example(("import_csv", "--out"), "\udcff")
@example(("linearize", "--out"), LONG)
@example(("linearize", "--out"), "\udcff")
@example(("linearize", "--out"), "\x1b[31mred")
@example(("linearize", "--out"), "a\0b")
@example(("import_csv", "--lean"), "nan")
@example(("import_csv", "--every"), "1" + "0" * 59)
@example(("compare", "--out"), LONG)
@example(("compare_searches", "--out"), LONG)
@example(("survey", "--out"), LONG)
@example(("identify", "--out"), LONG)
@example(("identify", "--config"), LONG)
def test_a_command_ends_with_a_code_and_one_line_whatever_an_option_says(place, capsys, case, text):
    name, option = case
    arguments = [*USUAL[name], option, text]
    if option != "--out" and name == "import_csv":
        arguments += ["--out", "bag"]
        shutil.rmtree("bag", ignore_errors=True)
    ends(importlib.import_module(EXECUTABLES[name]).main, arguments, capsys)


def parameters_of(node):
    """Return the parameters of a node by the file that lists them all."""
    file = ROOT / "config" / ("simulator.yaml" if node == "simulator" else "rig.yaml")
    values = yaml.safe_load(file.read_text())
    section = next(value for key, value in values.items() if key.endswith(node))["ros__parameters"]

    def flat(content, prefix=""):
        for key, value in content.items():
            yield from flat(value, f"{prefix}{key}.") if isinstance(value, dict) else [f"{prefix}{key}"]

    return list(flat(section))


USUAL_OF_NODES = {"driver": [], "recorder": [], "emulator": ["--link", "port"], "simulator": []}
NODE_CASES = [(name, option) for name in NODES for option in options_of(name)] + [
    (name, f"{parameter}:=") for name in NODES if name != "emulator" for parameter in parameters_of(name)
]


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(case=st.sampled_from(NODE_CASES), text=TEXTS)
@example(("emulator", "--link"), LONG)
@example(("emulator", "--speed"), "1e-300")
@example(("simulator", "source:="), "a b")
@example(("simulator", "source:="), "/")
@example(("simulator", "source:="), "a//b")
@example(("simulator", "--bag"), LONG)
@example(("recorder", "folder:="), LONG)
@example(("recorder", "folder:="), "")
@example(("recorder", "added.inner:="), " ")
@example(("driver", "baud:="), " ")
@example(("simulator", "start.inner:="), " ")
@example(("driver", "port:="), LONG)
def test_a_node_starts_or_ends_with_a_code_and_one_line_whatever_it_is_told(place, capsys, case, text):
    name, option = case
    told = ["--ros-args", "-p", f"{option}{text}"] if option.endswith(":=") else [option, text]
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    signal.signal(signal.SIGTERM, lambda *_: None)  # until the node has its own
    ended = threading.Event()

    def end():
        while not ended.wait(0.2):
            os.kill(os.getpid(), signal.SIGTERM)

    ender = threading.Thread(target=end)
    ender.start()
    try:
        ends(importlib.import_module(EXECUTABLES[name]).main, [*USUAL_OF_NODES[name], *told], capsys)
    finally:
        ended.set()
        ender.join()
        for number, handler in handlers.items():
            signal.signal(number, handler)


def ends(main, arguments, capsys):
    """Run an executable; it is to return an exit code, and bad input is told in one line that commands no terminal."""
    code = main(arguments)
    out, err = capsys.readouterr()
    assert code in (0, 2, 3), (arguments, code)
    if code == 2:
        *_, last = err.splitlines()
        assert re.match(r"\w+: error: .+", last), err
    assert "Traceback" not in err
    assert "\x1b[31m" not in out + err
