"""Lessons: what they say, what their buttons set up, and exercises whose answers are worked out.

No answer is written down here: each is computed by the engine and the simulator when it is asked
for, so a lesson cannot disagree with the program.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable
from typing import Any, final

from ..core import SettingError


@dataclasses.dataclass(frozen=True)
class Do:
    """A button of a lesson.

    Attributes:
        words: What it says.
        tab: The tab that is turned to.
        act: What it does to a session.
    """

    words: str
    tab: str
    act: Callable[[Any], object]


@dataclasses.dataclass(frozen=True)
class Exercise:
    """A question with an answer that can be checked.

    Attributes:
        question: The question.
        answer: Works the answer out.
        hint: Said after a wrong answer.
        told: Said after the right one.
        choices: Key and words of each choice; none where a number is asked for.
        slack: A number this near is right.
        unit: Its unit.
    """

    question: str
    answer: Callable[[], float | str]
    hint: str
    told: str
    choices: tuple[tuple[str, str], ...] = ()
    slack: float = 0.0
    unit: str = ""


@dataclasses.dataclass(frozen=True)
class Step:
    """A step of a lesson: words, buttons, exercises."""

    title: str
    text: tuple[str, ...]
    does: tuple[Do, ...] = ()
    exercises: tuple[Exercise, ...] = ()


@dataclasses.dataclass(frozen=True)
class Lesson:
    """A lesson.

    Attributes:
        key: Its name, also that of its notebook.
        title: Its title.
        minutes: How long it takes.
        question: What it answers.
        steps: Its steps.
    """

    key: str
    title: str
    minutes: int
    question: str
    steps: tuple[Step, ...]

    @property
    def exercises(self) -> list[Exercise]:
        """All of its exercises."""
        return [each for step in self.steps for each in step.exercises]


@final
class LessonsModel:
    """How far one session has come: which lesson is open, which exercises are solved."""

    def __init__(self) -> None:
        self.open = ""
        self.solved: set[tuple[str, int]] = set()
        self.said: dict[tuple[str, int], str] = {}

    def try_answer(self, lesson: Lesson, number: int, given: Any) -> bool:
        """Check an answer; returns whether it is right, and keeps what is to be said about it.

        Args:
            lesson: Which lesson.
            number: Which of its exercises.
            given: The key of a choice, or a number as text.
        """
        exercise = lesson.exercises[number]
        try:
            right = check(exercise, given)
            self.said[lesson.key, number] = exercise.told if right else exercise.hint
        except SettingError as error:
            right, self.said[lesson.key, number] = False, str(error)
        if right:
            self.solved.add((lesson.key, number))
        return right

    def share(self, lesson: Lesson) -> float:
        """Share of a lesson's exercises that are solved."""
        done = sum((lesson.key, i) in self.solved for i in range(len(lesson.exercises)))
        return done / len(lesson.exercises)


def check(exercise: Exercise, given: Any) -> bool:
    """Whether an answer is right.

    Raises:
        SettingError: It is no answer at all: no number, or none of the choices.
    """
    right = right_answer(exercise)
    if exercise.choices:
        if not isinstance(given, str) or given not in dict(exercise.choices):
            raise SettingError("choose one of the answers")
        return bool(given == right)
    try:
        number = float(str(given).strip().replace(",", "."))
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise SettingError("write a number, like 12 or 0.5")
    return abs(number - float(right)) <= exercise.slack + 1e-12


@functools.lru_cache(maxsize=64)
def right_answer(exercise: Exercise) -> float | str:
    """The answer, worked out once."""
    return exercise.answer()
