from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rovernav.control import GoalSeeker, check_controller
from rovernav.core import ContractError, PluginError, make_plugin, plugin, plugins
from rovernav.learn import find_controller
from rovernav.sim import (
    Odometry,
    RangeFan,
    check_metric,
    check_sensor,
    find_metric,
    find_sensor,
    load_trace,
    metric_names,
)
from tests.cli.installed import Install, forget, installer, page_file
from tests.cli.runner import run, tell, write_ground

OURS = ("closest", "detour", "energy", "length")
FILES = ("swerve.py", "compass.py", "turning.py")


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    yield installer(tmp_path, monkeypatch)
    forget({"swerve.py": "", "compass.py": "", "turning.py": "", "broken.py": ""})


@pytest.fixture
def page(root: Path) -> str:
    return (root / "docs/how-to/plug-ins.md").read_text(encoding="utf-8")


@pytest.fixture
def mine(install: Install, page: str) -> None:
    """The package of the page."""
    install(
        "my-rover",
        {name: page_file(page, name) for name in FILES},
        controller={"swerve": "swerve:Swerve"},
        sensor={"compass": "compass:Compass"},
        metric={"turning": "turning:Turning"},
    )


def broken(install: Install, text: str, **offers: dict[str, str]) -> None:
    forget({"broken.py": ""})
    install("bad-luck", {"broken.py": text}, version="0.3", **offers)


@pytest.mark.usefixtures("mine")
def test_parts_are_found_by_name_and_keep_their_contracts() -> None:
    found = [(one.kind, one.name, one.distribution) for k in
             ("controller", "sensor", "metric") for one in plugins(k)]  # fmt: skip
    assert found == [("controller", "swerve", "my-rover 1.0"),
                     ("sensor", "compass", "my-rover 1.0"),
                     ("metric", "turning", "my-rover 1.0")]  # fmt: skip
    check_controller(find_controller("swerve"))
    check_sensor(find_sensor("compass"))
    check_metric(find_metric("turning"))
    assert metric_names() == sorted([*OURS, "turning"])


def test_the_pages_pyproject_offers_what_the_page_says(page: str) -> None:
    import tomllib

    project = tomllib.loads(page_file(page, "pyproject.toml"))["project"]
    assert project["entry-points"] == {"rovernav.controllers": {"swerve": "swerve:Swerve"}}
    lines = [line for line in page_file(page, "swerve.py").splitlines() if line.startswith("    ")]
    assert len(lines) <= 10


def test_the_page_says_what_happens(
    install: Install, here: Path, page: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    from tests.docs.pages import fits
    from tests.docs.pages import run as run_page

    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("NO_COLOR", "1")
    files = {"swerve.py": page_file(page, "swerve.py")}
    install("my-rover", files, controller={"swerve": "swerve:Swerve"})
    shown = page.replace("pip install ./my-rover", "true").replace("```sh", "```bash")
    outputs = 0
    for step, printed in run_page(shown.replace("```py\n", "```python\n"), here):
        if step.output is not None and step.title is None:
            assert fits(step.output["text"], printed), printed
            outputs += 1
    assert outputs == 2


@pytest.mark.usefixtures("mine")
def test_they_drive_sense_and_measure_on_the_command_line(here: Path) -> None:
    report = tell("drive", "rocky-hills-v1", "--controller", "swerve", "--carry", "compass",
                  "--metrics", "turning,length,energy")  # fmt: skip
    trace = load_trace(Path(report["files"][3]))
    assert trace.channels["compass"].shape == (report["steps"], 1, 1)
    off = trace.channels["compass"][:, 0, 0] - trace.pose[:-1, 0, 2]
    assert np.ptp(off) < 1e-12
    turned = np.abs(np.diff(np.unwrap(trace.pose[:, 0, 2]))).sum()
    assert report["metrics"]["turning"][1] == "rad"
    np.testing.assert_allclose(report["metrics"]["turning"][0], turned, rtol=1e-9)
    assert report["metrics"]["length"] == [report["length_m"], "m"]
    assert report["metrics"]["energy"] == [None, "J"]
    assert trace.settings["carry"] == ["compass"]
    assert tell("export", report["files"][3], "--to", "t.csv")["ground"] is True
    assert "compass_0" in Path("t.csv").read_text().splitlines()[0]


@pytest.mark.usefixtures("mine")
def test_they_are_compared_whoever_does_the_work(here: Path) -> None:
    write_ground(here / "ground.tif")
    words = ("compare", "ground.tif", "--controllers", "swerve,goal-seeker", "--pairs", "23",
             "--metrics", "turning,detour", "--carry", "compass", "--nearest", "4")  # fmt: skip
    one = tell(*words)
    assert [score["controller"] for score in one["scores"]] == ["swerve", "goal-seeker"]
    assert all(score["metrics"]["turning"]["drives"] == 23 for score in one["scores"])
    reached = [score["outcomes"].get("reached", 0) for score in one["scores"]]
    assert [score["metrics"]["detour"]["drives"] for score in one["scores"]] == reached
    plain = tell(*words[:6])
    assert plain["scores"][1]["outcomes"] == one["scores"][1]["outcomes"]
    said = run(*words)
    assert "Medians of what was measured" in said.out
    assert "turning [rad]" in said.out


@pytest.mark.usefixtures("mine")
def test_parts_of_a_batch_measure_the_same(here: Path) -> None:
    from rovernav.bench import draw_pairs, score
    from rovernav.core import Threads
    from rovernav.rover import read_rover
    from rovernav.terrain import read_terrain

    write_ground(here / "ground.tif")
    pairs = draw_pairs(read_terrain("ground.tif"), read_rover("research"), 23, nearest=4.0)
    both = [
        score(pairs, "x", GoalSeeker(), executor=who, metrics=[find_metric("turning")])
        for who in (None, Threads(2))
    ]
    assert both[0].metrics == both[1].metrics
    assert both[0].metrics["turning"]["median"] > 0.0
    assert np.array_equal(both[0].trace.pose, both[1].trace.pose)


@pytest.mark.usefixtures("mine")
def test_a_scenario_file_names_them(here: Path) -> None:
    Path("s.yaml").write_text(
        "from: [0, 0]\nto: [8, 1]\ncircles: [[4, 0, 1]]\nrover: research\ncontroller: swerve\n"
        "carry: [compass]\n"
    )
    report = tell("drive", "s.yaml")
    assert report["settings"]["carry"] == ["compass"]
    assert load_trace(Path(report["files"][3])).channels["compass"].size == report["steps"]


BROKEN = {
    "import nothing_of_that_name": "cannot be loaded: ModuleNotFoundError: No module",
    "x = ": "cannot be loaded: SyntaxError:",
    "pass": "cannot be loaded: AttributeError:",
    "import sys; sys.exit(3)": "cannot be loaded: SystemExit: 3",
    "def part(): return 1 / 0": "cannot be made: ZeroDivisionError: division by zero",
    "def part(must): ...": "cannot be made: TypeError:",
    "def part(): return 7": "is no controller: it needs start and act",
}


@pytest.mark.parametrize(("text", "sentence"), BROKEN.items(), ids=range(len(BROKEN)))
def test_a_broken_one_is_one_sentence_and_breaks_nothing_else(
    install: Install, here: Path, text: str, sentence: str
) -> None:
    broken(install, text, controller={"hapless": "broken:part"})
    said = run("drive", "bassil-v1", "--controller", "hapless")
    assert said.code == 2
    assert f"the controller 'hapless' of bad-luck 0.3 {sentence}" in said.err
    assert len(said.err.splitlines()) == 1
    assert "Traceback" not in said.err
    assert not Path("rovernav-drive").exists()
    assert run("drive", "bassil-v1").code == 0
    assert "hapless" in run("plugins").out
    checked = run("plugins", "--check")
    assert checked.code == 1
    assert "hapless: the controller 'hapless' of bad-luck 0.3" in checked.out


FAULTY = """
class part:
    def start(self, mission, rng): return None
    def act(self, observation, memory): {}
"""


@pytest.mark.parametrize(
    ("does", "sentence"),
    [
        ("raise RuntimeError('out of luck')", "RuntimeError: out of luck"),
        ("return None", "TypeError: "),
        ("return observation.nothing, None", "AttributeError: "),
    ],
)
def test_one_that_fails_on_the_way_is_named(
    install: Install, here: Path, does: str, sentence: str
) -> None:
    broken(install, FAULTY.format(does), controller={"hapless": "broken:part"})
    said = run("drive", "bassil-v1", "--controller", "hapless")
    assert said.code == 1
    assert f"the controller 'hapless' of bad-luck 0.3 may be at fault: {sentence}" in said.err
    assert "rovernav plugins --check" in said.err
    assert tell("plugins", "--check", code=1)["plugins"][0]["fault"].startswith(
        "the controller 'hapless' of bad-luck 0.3 failed"
    )


def test_one_that_breaks_its_contract_is_told_so(install: Install) -> None:
    text = (
        "import numpy as np\nfrom rovernav.core import Command\n"
        + FAULTY.format("self.n = getattr(self, 'n', 0) + 0.01; "
                        "return Command(twist=np.full((len(observation.goal), 3), self.n)), None")
    )  # fmt: skip
    broken(install, text, controller={"hapless": "broken:part"})
    fault = tell("plugins", "--check", code=1)["plugins"][0]["fault"]
    assert fault == (
        "the controller 'hapless' of bad-luck 0.3: controller part: "
        "the same memory gives another result the next time"
    )


def test_two_that_offer_the_same_name_are_both_named(install: Install, here: Path) -> None:
    for name in ("one-rover", "two-rover"):
        install(name, {}, controller={"swerve": "nowhere:Swerve"})
    said = run("drive", "bassil-v1", "--controller", "swerve")
    assert said.code == 2
    both = "one-rover 1.0 and two-rover 1.0 both offer a controller 'swerve'; uninstall one of them"
    assert both in said.err


def test_our_names_cannot_be_taken(install: Install) -> None:
    broken(install, "raise RuntimeError", controller={"goal-seeker": "broken:part"},
           metric={"length": "broken:part"})  # fmt: skip
    assert isinstance(find_controller("goal-seeker"), GoalSeeker)
    assert find_metric("length").unit == "m"


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("--controller", "swerv"), "did you mean 'swerve'?"),
        (("--metrics", "turnin"), "there is no metric 'turnin'; did you mean 'turning'? Allowed: "
                                  "closest, detour, energy, length, turning."),
        (("--carry", "compas"), "there is no sensor 'compas'; did you mean 'compass'?"),
        (("--carry", "compass,compass"), "each once"),
        (("--metrics", ","), "give one or more names"),
    ],
)  # fmt: skip
@pytest.mark.usefixtures("mine")
def test_names_that_nobody_knows(here: Path, words: tuple[str, ...], sentence: str) -> None:
    said = run("drive", "bassil-v1", *words)
    assert said.code == 2
    assert sentence in said.err


def test_without_plug_ins(here: Path) -> None:
    assert run("plugins").out == "No installed package offers controllers, sensors or metrics.\n"
    assert tell("plugins", "--check") == {"plugins": []}
    assert plugin("sensor", "compass") is None
    with pytest.raises(PluginError, match="no installed package offers a sensor"):
        make_plugin("sensor", "compass")


def test_a_second_sensor_of_the_same_name_is_refused(install: Install, here: Path) -> None:
    text = "from rovernav.sim import ClearSight as part"
    broken(install, text, sensor={"sight": "broken:part"})
    said = run("drive", "bassil-v1", "--carry", "sight")
    assert (said.code, "two sensors 'clear_sight'" in said.err) == (2, True)


def test_nothing_is_imported_before_it_is_asked_for(install: Install) -> None:
    site = install(
        "my-rover", {"swerve.py": "raise RuntimeError"}, controller={"swerve": "swerve:Swerve"}
    )
    script = (
        "import sys; from rovernav.core import plugins; import rovernav.learn;"
        "print([p.name for p in plugins('controller')], 'swerve' in sys.modules)"
    )
    path = [str(site), *sys.path]
    done = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path[:] = {json.dumps(path)}; {script}"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout == "['swerve'] False\n"


class Faulty:
    """A metric with one fault."""

    name, unit = "faulty", "1"

    def __init__(self, give: Any) -> None:
        self.give = give

    def compute(self, trace: Any, worlds: Any) -> Any:
        return self.give(trace, worlds)


def _zeros(trace: Any) -> Any:
    return np.zeros(len(trace.steps)), np.ones(len(trace.steps), bool)


@pytest.mark.parametrize(
    ("give", "sentence"),
    [
        (lambda t, w: np.zeros(6), "must give values and which"),
        (lambda t, w: (np.zeros(3), _zeros(t)[1]), "values must be float64"),
        (lambda t, w: (_zeros(t)[0], np.ones(len(t.steps))), "marks must be bool"),
        (lambda t, w: (_zeros(t)[0] / 0.0, _zeros(t)[1]), "not finite"),
        (lambda t, w: (_zeros(t)[0] + t.length.sum(), _zeros(t)[1]), "alone gets another value"),
        (lambda t, w: (np.random.default_rng().random(len(t.steps)), _zeros(t)[1]), "next time"),
        (lambda t, w: (t.length.__imul__(2.0), _zeros(t)[1]), "tries to change what it is given"),
    ],
)
def test_the_checker_notices_a_metric_that_breaks_its_contract(give: Any, sentence: str) -> None:
    with np.errstate(all="ignore"), pytest.raises(ContractError, match=sentence):
        check_metric(Faulty(give))


def test_no_metric_at_all() -> None:
    with pytest.raises(ContractError, match="needs a name, a unit and compute"):
        check_metric(3)


@pytest.mark.parametrize("name", OURS)
def test_our_metrics_keep_their_contract(name: str) -> None:
    check_metric(find_metric(name))


def test_our_parts_pass_without_being_told_what_to_see() -> None:
    for name in ("goal-seeker", "planner", "neural", "bassil"):
        check_controller(find_controller(name))
    for sensor in (RangeFan(reach=4.0), Odometry()):
        check_sensor(sensor)
