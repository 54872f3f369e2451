"""The pages with a simulated user, in this process."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from nicegui import ElementFilter, ui
from nicegui.elements.upload_files import SmallFileUpload
from nicegui.testing import User

from rovernav.learn import paper_network, patterns_csv, shipped_patterns, worked_example
from rovernav.nets import network_bytes
from rovernav.studio import Sessions
from rovernav.studio._session import MOST
from tests.bits import assert_same_bits

Play = Callable[[Callable[[User, Sessions], Any]], None]


async def until(check: Callable[[], object], seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not check():
        assert time.monotonic() < end, "nothing happened"
        await asyncio.sleep(0.02)


async def opened(user: User, sessions: Sessions) -> Any:
    """The session behind the page that the user opens."""
    await user.open("/")
    assert user.client is not None
    key = user.client.request.url.path.removeprefix("/s/")
    session = sessions.find(key)
    assert session is not None
    return session


def field(user: User, mark: str) -> Any:
    (element,) = user.find(marker=mark).elements
    return element


def write(user: User, mark: str, text: str) -> Any:
    assert user.client is not None
    element = field(user, mark)
    with user.client:
        element.value = text
    return element


async def upload(user: User, name: str, data: bytes, number: int) -> None:
    assert user.client is not None
    with user.client:
        uploads = sorted(ElementFilter(kind=ui.upload, local_scope=False), key=lambda e: e.id)
    await uploads[number].handle_uploads([SmallFileUpload(name, "", data)])


def test_training_to_the_tolerance(studio_user: Play) -> None:
    async def scenario(user: User, sessions: Sessions) -> None:
        session = await opened(user, sessions)
        await user.should_see("Ready", retries=100)
        session.train.choose_speed("full")
        user.find(marker="start").click()
        await user.should_see("Learnt: every error is within the tolerance", retries=300)
        await user.should_see("215", retries=50)
        assert session.library.list()[0].summary["epochs"] == 215
        user.find("Runs").click()
        await user.should_see("2-3-2 on bassil-v1", retries=50)
        await user.should_see("rovernav train bassil-v1 --topology 2-3-2", retries=50)

    studio_user(scenario)


def test_steps_and_the_worked_example(studio_user: Play) -> None:
    async def scenario(user: User, sessions: Sessions) -> None:
        session = await opened(user, sessions)
        user.find("Worked example").click()
        await user.should_see("1 of 8: Sums into the hidden neurons", retries=50)
        for _ in range(4):
            user.find(marker="worked-next").click()
        await user.should_see("0.13227")
        await user.should_see("0.13223028")
        user.find(marker="worked-set-up").click()
        user.find(marker="step-pattern").click()
        await until(lambda: session.train.state().training.updates == 1)
        assert_same_bits(session.train.network.matrices[1], worked_example().w2)
        await user.should_see("0 + 1/4", retries=50)
        user.find(marker="step-epoch").click()
        await until(lambda: session.train.state().training.epoch == 1)
        user.find(marker="reset").click()
        assert session.train.state().training.updates == 0

    studio_user(scenario)


def test_the_pattern_table(studio_user: Play) -> None:
    async def scenario(user: User, sessions: Sessions) -> None:
        session = await opened(user, sessions)
        desk = session.desk
        write(user, "cell-0-1", "0.5")
        assert session.train.setup.table.x[0, 1] == 0.5
        assert session.train.setup.shipped == ""
        for wrong, said in (
            ("NaN", "NaN is not finite."), ("abc", "'abc' is not a number."),
            ("", "The cell is empty."), ("1_0", "'1_0' is not a number."),
        ):  # fmt: skip
            cell = write(user, "cell-0-1", wrong)
            assert cell.error == said[0].upper() + said[1:]
            await user.should_see("The training keeps the table without this")
            assert session.train.setup.table.x[0, 1] == 0.5
        write(user, "cell-0-1", "0")
        assert session.train.setup.shipped == "bassil-v1"
        name = write(user, "name-0", "off_line")
        assert name.error == "'off_line' stands twice."
        write(user, "name-0", "clear_sight")
        user.find(marker="add-pattern").click()
        assert len(desk.draft.cells) == 5
        user.find(marker="add-input").click()
        assert session.train.setup.topology == (3, 3, 2)
        user.find(marker="add-target").click()
        assert session.train.setup.topology == (3, 3, 3)
        await until(lambda: session.train.state().setup.table.x.shape == (5, 3))
        desk.load_shipped("bassil-v1")
        await user.should_see(marker="cell-3-3", retries=50)
        await user.should_not_see(marker="cell-4-0", retries=100)

    studio_user(scenario)


def test_settings_are_checked_in_words(studio_user: Play) -> None:
    async def scenario(user: User, sessions: Sessions) -> None:
        session = await opened(user, sessions)
        for mark, wrong, said in (
            ("eta", "0", "Eta must be a number above 0, got 0.0."),
            ("eta", "x", "Eta must be a number, got x."),
            ("momentum", "1", "Momentum must be from 0 to below 1, got 1.0."),
            ("epochs", "2.5", "Epochs must be a whole number, got 2.5."),
            ("seed", "nan", "Seed must be a number, got nan."),
        ):
            right = field(user, mark).value
            element = write(user, mark, wrong)
            assert element.error == said
            element = write(user, mark, right)
            assert element.error is None
        assert session.train.setup.settings.eta == 0.25
        write(user, "eta", "0.125")
        assert session.train.setup.settings.eta == 0.125
        session.train.preset({"eta": 0.5, "rule": "textbook", "hidden": "5", "weights": "seeded"})
        await until(lambda: field(user, "eta").value == "0.5")
        assert field(user, "rule").value == "textbook"
        assert field(user, "weights").value == "seeded"

    studio_user(scenario)


def test_uploads_of_tables_and_weights(studio_user: Play) -> None:
    async def scenario(user: User, sessions: Sessions) -> None:
        session = await opened(user, sessions)
        table = patterns_csv(shipped_patterns("bassil-replay-v1")).encode()
        await upload(user, "../x/mine.csv", table, 0)
        await until(lambda: session.train.setup.shipped == "bassil-replay-v1")
        await upload(user, "mine.csv", b"in:x,out:y\nnan,1\n", 0)
        await user.should_see("line 2, column 'in:x': nan is not finite", retries=50)
        await upload(user, "mine.txt.exe", b"MZ", 0)
        await user.should_see("give a file that ends in .csv or .txt", retries=50)
        network = paper_network().with_parameters(np.linspace(0, 1, 17))
        await upload(user, "w.safetensors", network_bytes(network), 1)
        await until(lambda: session.train.setup.weights == "given")
        assert_same_bits(session.train.network.parameters, np.linspace(0, 1, 17))
        await upload(user, "w.safetensors", b"\x80\x04pickled", 1)
        await user.should_see("is not a network file", retries=50)

    studio_user(scenario)


def test_two_sessions_do_not_disturb_each_other(studio_user: Play) -> None:
    async def scenario(user: User, sessions: Sessions) -> None:
        first = await opened(user, sessions)
        other = User(user.http_client)
        second = await opened(other, sessions)
        assert first is not second
        first.train.change(eta=0.5)
        second.train.change(hidden=(7,))
        assert (first.train.setup.hidden, second.train.setup.settings.eta) == ((3,), 0.25)
        first.train.choose_speed("full")
        first.train.change(tolerance=0, epochs=10**9)
        first.train.start()
        await until(lambda: first.train.state().training.epoch > 0)
        assert second.train.state().training.epoch == 0
        assert not second.train.running

    studio_user(scenario)


def test_a_closed_tab_does_not_end_its_training(studio_user: Play) -> None:
    async def scenario(user: User, sessions: Sessions) -> None:
        session = await opened(user, sessions)
        session.train.choose_speed("full")
        session.train.change(tolerance=0, epochs=10**9)
        session.train.start()
        assert user.client is not None
        user.client.delete()
        before = session.train.state().training.epoch
        await until(lambda: session.train.state().training.epoch > before + 1000)
        assert session.train.running
        await user.open(f"/s/{session.key}")
        await user.should_see("Training", retries=50)
        session.train.pause()
        await user.should_see("Paused", retries=50)

    studio_user(scenario)


def test_runs_are_renamed_compared_reopened_and_deleted(studio_user: Play) -> None:
    async def scenario(user: User, sessions: Sessions) -> None:
        session = await opened(user, sessions)
        train, library = session.train, session.library
        train.choose_speed("full")
        for momentum in (0.5, 0.9):
            train.change(momentum=momentum)
            train.reset()
            train.start()
            await until(lambda: train.state().kept)
        user.find("Runs").click()
        await user.should_see("momentum 0.9", retries=50)
        write(user, "run-name", "<script>alert(1)</script>")
        user.find(marker="rename").click()
        await user.should_see("<script>alert(1)</script>", retries=50)
        assert library.list()[0].title == "<script>alert(1)</script>"
        write(user, "run-name", " ")
        user.find(marker="rename").click()
        await user.should_see("a run needs a name", retries=50)
        session.runs.mark(library.list()[0].id, True)
        session.runs.mark(library.list()[1].id, True)
        await until(lambda: len(session.runs.compared()) == 2)
        await user.should_see("largest |error|", retries=50)
        train.preset({"hidden": "4", "eta": 0.01, "weights": "seeded"})
        user.find(marker="reopen").click()
        await until(lambda: session.tab == "Train")
        assert train.setup.settings.momentum == 0.9
        assert train.setup.topology == (2, 3, 2)
        user.find("Runs").click()
        user.find(marker="delete").click()
        user.find(marker="delete-it").click()
        await until(lambda: len(library.list()) == 1)

    studio_user(scenario)


def test_downloads(studio_user: Play) -> None:
    async def scenario(user: User, sessions: Sessions) -> None:
        session = await opened(user, sessions)
        session.train.choose_speed("full")
        session.train.start()
        await until(lambda: session.train.state().kept)
        user.find("Runs").click()
        for words, begin in (
            ("All files (ZIP)", b"PK"), ("trace.csv", b"epoch,pattern,matrix1[0][0]"),
            ("training.png", b"\x89PNG"), ("curve.csv", b"epoch,max_error,loss"),
            ("patterns.csv", b"in:clear_sight"),
        ):  # fmt: skip
            await user.should_see(words, retries=50)
            user.find(words).click()
            answer = await user.download.next(timeout=30)
            assert answer.content.startswith(begin)

    studio_user(scenario)


def test_unknown_sessions_begin_afresh(studio_user: Play) -> None:
    async def scenario(user: User, sessions: Sessions) -> None:
        await user.open("/s/nobody-knows-this")
        await user.should_see("rovernav studio")

    studio_user(scenario)


def test_sessions_are_bounded(studio_user: Play) -> None:
    async def scenario(user: User, sessions: Sessions) -> None:
        busy = sessions.begin("me")
        busy.train.change(tolerance=0, epochs=10**9)
        busy.train.start()
        keys = [sessions.begin("me").key for _ in range(MOST + 5)]
        assert sessions.find(busy.key) is busy
        assert sessions.find(keys[0]) is None
        assert sessions.find(keys[-1]) is not None
        assert len(sessions.of("me")) == MOST
        assert sessions.of("you") == []
        assert sessions.of("") == []

    studio_user(scenario)


def test_the_page_answers_while_ten_million_updates_run(studio_user: Play) -> None:
    """The promise is 100 ms; nine tenths of the answers must keep it even on a busy machine."""

    async def scenario(user: User, sessions: Sessions) -> None:
        session = await opened(user, sessions)
        train = session.train
        await until(lambda: field(user, "status").text == "Ready")
        train.choose_speed("full")
        train.change(tolerance=0, epochs=2_500_000)
        train.start()
        waits: list[float] = []
        while train.running:
            asked = time.perf_counter()
            await asyncio.sleep(0)  # all that stands before us in the event loop
            write(user, "seed", str(len(waits) + 1))  # read, checked, put into the setup
            assert train.setup.settings.seed == len(waits) + 1
            waits.append(time.perf_counter() - asked)
            await asyncio.sleep(0.01)
        assert train.state().training.updates == 10_000_000
        assert len(waits) > 10
        assert np.quantile(waits, 0.9) < 0.1

    studio_user(scenario)
