# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The node identify, on real bags: on the command line, and over DDS."""

import json
import math
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
import yaml
from rcl_interfaces.msg import ParameterEvent
from rclpy.parameter_client import AsyncParameterClient

from cdp_ident.commands.import_csv import main as import_csv
from cdp_ident.configuration.parameter_file import read_parameter_file
from cdp_ident.configuration.settings import Settings
from cdp_ident.model.parameters import GROUPS, INERTIA, NOMINAL
from cdp_ident.nodes.identify import main
from cdp_ident.output_folder import json_text
from cdp_ident.report.folder import FIGURES, FILES
from reference.pendulum import TABLE_5
from scenarios.clean_bags import write_clean_bags

pytestmark = pytest.mark.waits

ROOT = Path(__file__).parents[2]
BAGS = Path(tempfile.gettempdir()) / f"cdp_ident_clean_bags_{os.getpid()}"
WIDE, FOLDED = str(BAGS / "swing_wide"), str(BAGS / "swing_folded")
MEASURED = ROOT.parent / "shared/data/multiarm_free_swing/free_swing_8s_56s_1kHz.csv.gz"
SWING = 6.0
"""How long each trial is [s]."""
PATIENCE = 300.0
"""Longest wait for an end [s]: the machine may be busy, and may have to compile first."""
QUICK = ("--config", str(BAGS / "quick.yaml"))
"""A short search and no curves: what is tested here is neither how well it searches nor what it finds."""
ENDLESS = "{identify: {ros__parameters: {method: iga, search.generations: 1000000, named_effects_only: true}}}"


@pytest.fixture(scope="module", autouse=True)
def clean_bags():
    """Short, and nothing is hidden in them: what is tested here is not how effects are found, which takes its time."""
    write_clean_bags(BAGS, swing=SWING)
    (BAGS / "report.json").write_text("an earlier one")
    (BAGS / "bad.yaml").write_text("identify: {ros__parameters: {nominal: {m3: 1.0}}}")
    (BAGS / "quick.yaml").write_text("identify: {ros__parameters: {search.generations: 3, named_effects_only: true}}")
    yield
    shutil.rmtree(BAGS)


@pytest.fixture
def out(tmp_path):
    return tmp_path / "out"


def report_in(folder):
    return json.loads((folder / "report.json").read_text())


def identify(*arguments):
    """Run it as a process of its own, to its end."""
    command = [sys.executable, "-m", "cdp_ident", "identify", *arguments]
    return subprocess.run(command, cwd=ROOT, check=False, capture_output=True, text=True, timeout=300)


# On the command line


def test_once_it_identifies_prints_and_writes_a_folder_named_after_the_first_bag(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["--bag", WIDE, "--bag", FOLDED, "--once", *QUICK]) == 0
    out = tmp_path / "identification/swing_wide"
    report = report_in(out)
    assert [trial["bag"] for trial in report["trials"]] == [WIDE, FOLDED]
    values = yaml.safe_load((out / "fitted.yaml").read_text())["/**"]["ros__parameters"]
    assert values["m1"] == report["before"]["physical"]["m1"]["value"]
    printed = capsys.readouterr()
    assert "Error, measured against simulated" in printed.out
    assert "best error" in printed.err
    assert {path.name for path in out.iterdir()} == {*FILES} - {FIGURES}


def test_the_same_seed_gives_the_same_report_in_a_process_without_ros_too(tmp_path):
    arguments = ["--bag", WIDE, "--once", *QUICK, "--seed", "7", "--out"]
    assert main([*arguments, str(tmp_path / "one")]) == 0
    code = "import sys; sys.modules['rclpy'] = None; from cdp_ident.nodes.identify import main; sys.exit(main())"
    command = [sys.executable, "-c", code, *arguments, str(tmp_path / "two")]
    assert subprocess.run(command, cwd=ROOT, check=False, capture_output=True, timeout=300).returncode == 0
    one, two = (report_in(tmp_path / name) for name in ("one", "two"))
    for report in (one, two):
        del report["search"]["seconds"], report["run"]["seconds"], report["run"]["written_at"]
    assert one == two
    assert (tmp_path / "one/fitted.yaml").read_text() == (tmp_path / "two/fitted.yaml").read_text()


def test_ros_s_params_files_and_single_parameters_mean_the_same_as_a_configuration(tmp_path, out):
    in_file = {"nominal.m1": 0.12, "window": 2.0, "trial.stop": math.inf, "method": "tga", "search.generations": 2}
    (tmp_path / "some.yaml").write_text(yaml.safe_dump({"identify": {"ros__parameters": in_file}}))
    single = {"known.m2": 0.1154, "seed": 4, "window": 3}  # a whole number may stand for a real one
    ways = [
        *("--params-file", str(ROOT / "config/identify.yaml"), "--params-file", str(tmp_path / "some.yaml")),
        *(word for name, value in single.items() for word in ("-p", f"{name}:={value}")),
    ]
    done = identify("--bag", WIDE, "--out", str(out), "--once", "--ros-args", *ways)
    assert done.returncode == 0, done.stderr
    configuration = read_parameter_file(ROOT / "config/identify.yaml", "identify").taken() | in_file | single
    assert report_in(out)["run"]["options"] == json.loads(json_text(Settings.of(configuration).values()))


def test_with_force_it_is_replaced_and_the_command_line_wins_over_the_configuration(out, tmp_path):
    out.mkdir()
    (out / "report.json").write_text("an earlier one")
    (tmp_path / "some.yaml").write_text(
        "identify: {ros__parameters: {seed: 3, method: iga, window: 2.0, search.generations: 2}}"
    )
    options = ["--config", str(tmp_path / "some.yaml"), "--seed", "9", "--method", "tga", "--force"]
    assert main(["--bag", WIDE, "--out", str(out), "--once", *options]) == 0
    options = report_in(out)["run"]["options"]
    assert (options["seed"], options["method"], options["window"]) == (9, "tga", 2.0)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ([], "there is nothing to identify from: give at least one --bag, or a folder to --watch"),
        (["--watch", "trials"], "--watch goes on until Ctrl-C, so --once cannot go with it"),
        (["--bag", "nowhere"], "nowhere"),
        (["--bag", WIDE, "--holdout", WIDE], "given twice"),
        (["--bag", WIDE, "--seed", "-1"], "seed is -1"),
        (["--bag", WIDE, "--method", "sga"], "sga"),
        (["--bag", WIDE, "--config", "nowhere.yaml"], "nowhere.yaml"),
        (["--bag", WIDE, "--config", str(BAGS / "bad.yaml")], "'nominal.m3'; did you mean 'nominal.m"),
        (["--bag", WIDE, "--out", __file__], "is not a folder"),
        (["--bag", WIDE, "--out", str(BAGS)], "--force"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(options, words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main([*options, "--once"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("identify: error: ")
    assert error.count("\n") == 1
    assert words in error
    assert list(tmp_path.iterdir()) == []
    assert (BAGS / "report.json").read_text() == "an earlier one"


def test_a_fit_that_failed_is_one_line_a_report_and_exit_code_3(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    wrong = "{trial: {outer_scale: 1.4, conventions: warn}, search.generations: 3}"
    (tmp_path / "wrong.yaml").write_text(f"identify: {{ros__parameters: {wrong}}}")
    assert main(["--bag", WIDE, "--config", "wrong.yaml", "--once"]) == 3
    error = capsys.readouterr().err.splitlines()[-1]
    assert error.startswith("identify: error: the fit failed")
    assert "Check the counts per turn" in error
    folder = tmp_path / "identification" / "swing_wide"
    report = report_in(folder)
    assert report["verdict"].startswith("The fit failed")
    assert report["warnings"][0]["name"] == "fit_failed"
    assert report["effects"] == []
    assert not (folder / "fitted.yaml").exists()


@pytest.mark.parametrize("parameter", ["nominal.m3:=1.0", "window:=long"])
def test_a_bad_ros_parameter_is_one_line_and_exit_code_2(parameter, out, refused):
    line = refused(main, "--bag", WIDE, "--out", str(out), "--ros-args", "-p", parameter)
    assert parameter.partition(":")[0] in line


@pytest.mark.campaign
@pytest.mark.skipif(not MEASURED.exists(), reason="the measured swing is not beside the repository")
def test_a_measured_swing_is_identified_and_its_errors_printed(tmp_path, capsys):
    columns = ["--time", "time_s", "--inner", "theta1_rad", "--outer", "theta2_rad", "--outer-angle", "absolute"]
    assert import_csv([str(MEASURED), "--out", str(tmp_path / "measured"), "--every", "5", *columns]) == 0
    nominal = {"m1": 0.0938, "m2": 0.1376, "m0": 0.0, "l1": 0.1086, "l2": 0.1168, "J1": 4.4e-4, "J2": 1.27e-3}
    # Part of the 48 s is enough to see that it is identified; the selection of effects takes longer on all of it.
    values = {"L": 0.17272, "nominal": {**nominal, "c1": 2.4e-4, "c2": 1e-5}, "trial": {"stop": 12.0}}
    (tmp_path / "rig.yaml").write_text(yaml.safe_dump({"identify": {"ros__parameters": values}}))
    options = ["--config", str(tmp_path / "rig.yaml"), "--out", str(tmp_path / "out"), "--once"]
    assert main(["--bag", str(tmp_path / "measured"), *options]) == 0
    report = report_in(tmp_path / "out")
    errors = [report["before"]["error"][role]["rmse_rad"] for role in ("fit", "holdout")]
    assert all(error < 3.6e-3 for error in errors)  # the source's own fit leaves 3.8 mrad
    printed = capsys.readouterr().out
    assert all(f"{1e3 * error:.4g}" in printed for error in errors)
    assert "error_above_noise" in [warning["name"] for warning in report["warnings"]]


# Interrupted


@pytest.mark.parametrize(
    ("number", "once"),
    [
        (signal.SIGINT, ["--once"]),
        (signal.SIGTERM, []),
        pytest.param(signal.SIGTERM, ["--once"], marks=pytest.mark.campaign),
    ],
)
def test_ctrl_c_and_sigterm_keep_the_best_so_far_and_end_it(start, tmp_path, out, number, once):
    (tmp_path / "endless.yaml").write_text(ENDLESS)
    process = start("identify", "--bag", WIDE, "--out", str(out), *once, "--config", str(tmp_path / "endless.yaml"))
    process.wait_until_it_says("searching: generation")
    assert process.end(number) == 0
    report = report_in(out)
    assert report["search"]["stopped"] == "interrupted"
    assert report["warnings"][0]["name"] == "interrupted"
    assert report["before"]["error"]["holdout"]["rmse_rad"] < report["stages"]["nominal"]["holdout"]["rmse_rad"]
    assert "the best so far" in process.said or "its best so far" in process.said


# Over DDS


class Client:
    """Reads the parameters of /identify as any node does."""

    def __init__(self, listener):
        self.listener = listener
        self.client = AsyncParameterClient(listener.node, "/identify")
        self.states = listener.words("/identify/state")

    def wait_until_it_serves(self):
        self.listener.wait_for(lambda: "m1" in self.names())
        self.listener.wait_for(lambda: self.states and self.states[-1].startswith("ready"))

    def names(self):
        return self.listener.parameter_names("/identify")

    def values(self, *names):
        return list(self.listener.get_parameters("/identify", names).values())

    def descriptors(self, *names):
        return self.listener.answer(lambda: self.client.describe_parameters(list(names))).descriptors


@pytest.fixture
def client(listener):
    return Client(listener)


def test_it_serves_what_it_reports_with_descriptions_and_refuses_to_be_written(client, listener, out):
    """As `identify … | head -1`: what is printed has nobody to read it, and that is all."""
    reading, writing = os.pipe()
    os.close(reading)
    command = [sys.executable, "-m", "cdp_ident", "identify", "--bag", WIDE, "--out", str(out), *QUICK]
    with subprocess.Popen(command, cwd=ROOT, stdout=writing, stderr=subprocess.DEVNULL) as process:
        os.close(writing)
        try:
            listener.wait_for(lambda: (out / "report.html").exists() or process.poll() is not None)
            client.wait_until_it_serves()
            assert_served(client, listener, report_in(out)["before"])
            process.send_signal(signal.SIGINT)
            assert process.wait(timeout=PATIENCE) == 0
        finally:
            process.kill()


def assert_served(client, listener, fit):
    names = [*NOMINAL, INERTIA.symbol, *(f"groups.{group.symbol}" for group in GROUPS)]
    reported = [quantity["value"] for section in ("physical", "groups") for quantity in fit[section].values()]
    assert client.values(*names) == reported
    for name, descriptor in zip(names, client.descriptors(*names), strict=True):
        assert descriptor.description.endswith("]"), name
        assert descriptor.floating_point_range[0].from_value == 0.0
    assert {"std.m1", "determined.groups.c1_over_A22", "window", "lower.m1", "trial.zero"} <= set(client.names())
    listener.wait_for(lambda: client.states and client.states[-1].startswith("ready: swing_wide"))
    before = client.values("m1", "window")
    assert all(descriptor.read_only for descriptor in client.descriptors(*names, "window"))
    for name in ("m1", "window"):
        assert listener.set_parameter("/identify", name, 9.0) == (
            False,
            f"Trying to set a read-only parameter: {name}.",
        )
    assert client.values("m1", "window") == before


def test_it_identifies_again_with_what_configuration_and_bags_say_then(start, client, listener, tmp_path, out):
    config = tmp_path / "some.yaml"
    config.write_text(
        "identify: {ros__parameters: {window: 2.0, known.m1: 0.13, search.generations: 3, named_effects_only: true}}"
    )
    process = start("identify", "--bag", WIDE, "--out", str(out), "--config", str(config))
    client.wait_until_it_serves()
    assert client.values("window", "known.m1") == [2.0, 0.13]
    first = report_in(out)
    events = []
    listener.node.create_subscription(ParameterEvent, "/parameter_events", events.append, 1000)

    def all_is_as_before():
        assert client.values("m1", "window") == [first["after"]["physical"]["m1"]["value"], 2.0]
        assert report_in(out) == first

    config.write_text("identify: {ros__parameters: {seeed: 5}}")
    assert listener.call("/identify/identify_again")[0]
    listener.wait_for(lambda: any(state.startswith("failed: unknown key") for state in client.states))
    all_is_as_before()

    config.write_text(ENDLESS.replace("{method", "{window: 3.0, method"))
    assert listener.call("/identify/identify_again") == (True, "identifying: ~/state tells when it is done")
    assert listener.call("/identify/identify_again")[0] is False
    all_is_as_before()  # until the new is done
    process.wait_until_it_says("searching: generation", once_more=True)
    listener.wait_for(lambda: client.states[-1].startswith("identifying: "))  # once a second: this search has no end
    assert listener.call("/identify/cancel")[0]

    # A simulator that follows /identify has nothing else to go by than one event that tells all.
    def of_identify():
        return [event for event in events if event.node == "/identify"]

    listener.wait_for(of_identify)
    (event,) = of_identify()
    changed = {parameter.name: parameter.value.double_value for parameter in event.changed_parameters}
    assert changed["window"] == 3.0
    assert {"m1", "std.m1"} <= set(changed)
    assert "g" not in changed  # it has not
    listener.wait_for(lambda: client.values("window") == [3.0])
    listener.wait_for(lambda: client.states[-1].startswith("ready"))
    assert listener.call("/identify/cancel") == (False, "no search is running")
    assert "[WARN]" in process.said
    assert "interrupted: the search was ended early" in process.said
    assert {status.name for status in listener.statuses} >= {"/identify"}
    second = report_in(out)
    assert second["search"]["stopped"] == "interrupted"
    # Both searches lead to one maximum: a group may come out the same to the last bit, and is no change then.
    before, after = first["after"]["groups"], second["after"]["groups"]
    expected = {f"groups.{name}" for name in before if before[name]["value"] != after[name]["value"]}
    assert {name for name in changed if name.startswith("groups.")} == expected
    assert (
        client.values("m1")
        == [second["after"]["physical"]["m1"]["value"]]
        != [first["after"]["physical"]["m1"]["value"]]
    )
    assert "known.m1" not in client.names()
    assert len(of_identify()) == 1
    assert process.end() == 0


def test_a_folder_that_is_not_utf_8_is_watched_without_a_clock_too_and_told_with_escapes(
    start, client, listener, tmp_path, out
):
    trials = Path(os.fsdecode(os.fsencode(tmp_path) + b"/\xff"))
    process = start("identify", "--watch", str(trials), "--out", str(out), "--ros-args", "-p", "use_sim_time:=true")
    listener.wait_for(lambda: client.states == [f"waiting for a first trial in {tmp_path}/\\udcff"])
    listener.wait_for(lambda: any(status.name == "/identify" for status in listener.statuses))
    write_broken_bag(trials / "broken")
    listener.wait_for(lambda: client.states[-1].startswith("failed: "))
    assert "broken is left out: " in process.said
    assert process.end() == 0


def test_bags_are_given_to_the_node_as_a_goal_and_those_that_are_not_there_leave_it_running(
    start, client, listener, tmp_path, out
):
    process = start("identify", "--watch", str(tmp_path), "--out", str(out), *QUICK)
    listener.wait_for(lambda: client.states == [f"waiting for a first trial in {tmp_path}"])

    def identify(*bags):
        assert listener.set_parameter("/identify", "bags", list(bags))[0]
        assert listener.call("/identify/identify_again")[0]

    for bag, complaint in (
        ("~no_such_user/one", "is no path"),
        ("nowhere", "there is no bag nowhere"),
        ("", "nothing to"),
    ):
        identify(bag)
        listener.wait_for(
            lambda complaint=complaint: client.states[-1].startswith("failed") and complaint in client.states[-1]
        )
    identify(WIDE)
    client.wait_until_it_serves()
    assert [trial["bag"] for trial in report_in(out)["trials"]] == [WIDE]
    assert process.end() == 0


def write_broken_bag(folder):
    folder.mkdir(parents=True)
    (folder / f"{folder.name}_0.mcap").write_text("nothing")
    (folder / "metadata.yaml").write_text("nothing")


def test_trials_that_come_into_a_watched_folder_are_checked_then_fitted_too(start, client, listener, tmp_path, out):
    trials = tmp_path / "trials"
    process = start("identify", "--watch", str(trials), "--out", str(out), *QUICK)
    listener.wait_for(lambda: client.states == [f"waiting for a first trial in {trials}"])

    def record(bag, name):
        shutil.copytree(bag, tmp_path / name)
        trials.mkdir(exist_ok=True)
        (tmp_path / name).rename(trials / name)

    def trials_in_report():
        return [trial["name"] for trial in report_in(out)["trials"]] if (out / "report.json").exists() else []

    record(WIDE, "first")
    client.wait_until_it_serves()
    assert report_in(out)["new_trials"] == []

    write_broken_bag(trials / "broken")
    write_clean_bags(tmp_path / "changed", {**TABLE_5, "c2": 1.05 * TABLE_5["c2"]}, SWING)
    record(FOLDED, "second")
    record(tmp_path / "changed/swing_folded", "third")
    listener.wait_for(lambda: trials_in_report() == ["first", "second", "third"])
    assert "broken is left out: " in process.said
    report = report_in(out)
    second, third = report["new_trials"]
    assert (second["trial"], second["fits"]) == ("second", True)
    assert (third["trial"], third["fits"], third["changed"][0]["name"]) == ("third", False, "c2_over_A22")
    assert "no_longer_fits" in [warning["name"] for warning in report["warnings"]]
    assert "third no longer fits" in process.said
    listener.wait_for(lambda: client.values("m1") == [report["after"]["physical"]["m1"]["value"]])
    assert process.end() == 0
