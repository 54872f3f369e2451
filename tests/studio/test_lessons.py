"""The lessons: every answer is worked out, every button sets up what it says."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rovernav.core import Outcome, SettingError
from rovernav.studio import Library, Options
from rovernav.studio._lesson_facts import exact_gradient, trained
from rovernav.studio._lesson_texts import LESSONS
from rovernav.studio._lessons import LessonsModel, check, right_answer
from rovernav.studio._session import Session

EXERCISES = [
    pytest.param(lesson, number, id=f"{lesson.key}-{number}")
    for lesson in LESSONS
    for number in range(len(lesson.exercises))
]
ANSWERS = {
    "why-two-bits-fail": [215, 7, "collided", "0, 0", "up", 45, "reached"],
    "learning-rate-and-momentum": [1164, 215, "0.9", "0.5", "0.75", "1", 2391],
    "the-papers-rule": [-0.60249983, -0.68041906, "textbook", 674, "paper", "textbook"],
}
"""What shared figures, the paper's table of epochs and the worked example say."""


@pytest.fixture
def session(tmp_path: Path) -> Iterator[Session]:
    library = Library(tmp_path / "runs.sqlite3")
    made = Session("key", "owner", Options(show=False), library)
    yield made
    made.close()


def settled(session: Session) -> None:
    until = time.monotonic() + 60
    while (session.train.running or session.drive.running) and time.monotonic() < until:
        time.sleep(0.01)
    assert not session.busy


@pytest.mark.parametrize(("lesson", "number"), EXERCISES)
def test_answers_are_those_of_independent_tables(lesson: Any, number: int) -> None:
    exercise, there = lesson.exercises[number], ANSWERS[lesson.key][number]
    assert check(exercise, there)
    if exercise.choices:
        assert right_answer(exercise) in dict(exercise.choices)
        wrong = next(key for key, _ in exercise.choices if key != there)
        assert not check(exercise, wrong)
    else:
        assert check(exercise, f" {right_answer(exercise)!r} ")
        assert not check(exercise, float(there) + 3 * exercise.slack + 1)


def test_every_exercise_has_an_independent_answer() -> None:
    assert {lesson.key: len(lesson.exercises) for lesson in LESSONS} == {
        key: len(answers) for key, answers in ANSWERS.items()
    }
    assert all(lesson.minutes == 20 for lesson in LESSONS)


def test_the_slope_by_differences_is_the_gradient() -> None:
    from rovernav.learn import worked_example

    change = float(worked_example("textbook").w1[0, 2]) - 0.1
    assert change == pytest.approx(-0.25 * exact_gradient(), abs=1e-12)


@pytest.mark.parametrize("given", ["", "x", "nan", "inf", None, "<b>7</b>", "7 7"])
def test_what_is_no_number_is_told_so(given: Any) -> None:
    with pytest.raises(SettingError, match="write a number"):
        check(LESSONS[0].exercises[0], given)


def test_what_is_none_of_the_choices_is_told_so() -> None:
    with pytest.raises(SettingError, match="choose one"):
        check(LESSONS[0].exercises[2], "flies")


def test_progress_is_kept_and_words_follow_the_answer() -> None:
    model, lesson = LessonsModel(), LESSONS[0]
    assert not model.try_answer(lesson, 0, "7")
    assert model.said[lesson.key, 0] == lesson.exercises[0].hint
    assert not model.try_answer(lesson, 0, "seven")
    assert "write a number" in model.said[lesson.key, 0]
    assert model.share(lesson) == 0.0
    assert model.try_answer(lesson, 0, "215")
    assert model.said[lesson.key, 0] == lesson.exercises[0].told
    assert model.share(lesson) == pytest.approx(1 / 7)
    assert LessonsModel().share(lesson) == 0.0


def test_the_first_lesson_as_its_buttons_go(session: Session) -> None:
    outcomes = []
    for step in LESSONS[0].steps:
        for do in step.does:
            session.train.choose_speed("full")
            do.act(session)
            session.train.choose_speed("full")
            settled(session)
            if do.tab == "Drive":
                outcomes.append([run.outcome for run in session.drive.runs])
            else:
                assert session.train.state().training.epoch == 215
    good, bad = [Outcome.REACHED], [Outcome.COLLIDED]
    assert outcomes == [good, bad, good, bad, [*bad, *good]]


@pytest.mark.parametrize("lesson", LESSONS[1:], ids=lambda lesson: lesson.key)
def test_training_buttons_train_with_the_settings_they_name(lesson: Any, session: Session) -> None:
    for step in lesson.steps:
        for do in step.does:
            do.act(session)
            session.train.choose_speed("full")
            settled(session)
            state = session.train.state()
            s = state.setup.settings
            if "Set up" in do.words:
                assert state.training.epoch == 0
                continue
            epochs, stop = trained(s.eta, s.momentum, s.rule, s.tolerance)
            assert (state.training.epoch, state.training.stop) == (epochs, stop), do.words
