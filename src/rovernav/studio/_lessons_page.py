"""The Lessons tab."""

from __future__ import annotations

from functools import partial
from typing import Any, final

from nicegui import run, ui

from ..core import RovernavError
from ._lesson_texts import LESSONS
from ._lessons import Do, Exercise, Lesson, Step
from ._session import Session
from ._uploads import refuse


def lessons_tab(session: Session) -> None:
    """Build the tab in the present container."""
    _LessonsTab(session).build()


@final
class _LessonsTab:
    def __init__(self, session: Session) -> None:
        self.session, self.model = session, session.lessons

    def build(self) -> None:
        self.room = ui.column().classes("w-full rnl-room")
        self._fill()

    def _fill(self) -> None:
        self.room.clear()
        lesson = next((each for each in LESSONS if each.key == self.model.open), None)
        with self.room:
            if lesson is None:
                self._list()
            else:
                self._lesson(lesson)

    def _open(self, key: str, _: object = None) -> None:
        self.model.open = key
        self._fill()

    def _list(self) -> None:
        ui.label("Three lessons of twenty minutes").classes("rnl-head")
        ui.label(
            "Each sets up the Train and Drive tabs for you, asks a few questions and checks the "
            "answers. The same lessons are notebooks in the documentation."
        ).classes("rn-note")
        with ui.element("div").classes("rnl-cards"):
            for lesson in LESSONS:
                with ui.column().classes("rn-card rnl-card"):
                    ui.label(lesson.title).classes("rnl-title")
                    ui.label(lesson.question).classes("rnl-text")
                    ui.space()
                    self._progress(lesson)
                    begun = self.model.share(lesson) > 0
                    ui.button("Go on" if begun else "Begin",
                              on_click=partial(self._open, lesson.key)).props(
                        f'unelevated aria-label="{lesson.title}"'
                    ).mark(f"open-{lesson.key}")  # fmt: skip

    def _progress(self, lesson: Lesson) -> None:
        done = round(self.model.share(lesson) * len(lesson.exercises))
        with ui.row().classes("w-full items-center no-wrap gap-2"):
            ui.linear_progress(self.model.share(lesson), show_value=False, size="6px").props(
                'rounded aria-hidden=true')  # fmt: skip
            ui.label(f"{done} of {len(lesson.exercises)}").classes("rn-note rn-num rnl-done")

    def _lesson(self, lesson: Lesson) -> None:
        with ui.row().classes("w-full items-center no-wrap gap-2"):
            ui.button(icon="arrow_back", color=None, on_click=partial(self._open, "")).props(
                'flat dense round aria-label="All lessons"').mark("all-lessons")  # fmt: skip
            ui.label(lesson.title).classes("rnl-head")
            ui.space()
            self.done = ui.row().classes("rnl-progress")
            with self.done:
                self._progress(lesson)
        ui.label(lesson.question).classes("rnl-text")
        number = 0
        for at, step in enumerate(lesson.steps, 1):
            with ui.element("div").classes("rn-card rnl-step"):
                number = self._step(lesson, step, at, number)

    def _step(self, lesson: Lesson, step: Step, at: int, number: int) -> int:
        with ui.column().classes("gap-2"):
            ui.label(f"{at}. {step.title}").classes("rnl-title")
            for paragraph in step.text:
                ui.label(paragraph).classes("rnl-text")
            if step.does:
                with ui.row().classes("gap-2"):
                    for do in step.does:
                        ui.button(do.words, icon="play_arrow",
                                  on_click=partial(self._act, do)).props(
                            "outline").mark("do")  # fmt: skip
        with ui.column().classes("gap-3 rnl-ask"):
            for exercise in step.exercises:
                self._exercise(lesson, exercise, number)
                number += 1
        return number

    def _exercise(self, lesson: Lesson, exercise: Exercise, number: int) -> None:
        with ui.column().classes("gap-1 w-full"):
            ui.label(exercise.question).classes("rnl-question")
            with ui.row().classes("items-center gap-2 w-full"):
                given = self._field(exercise, number)
                ui.button("Check", on_click=lambda: answer()).props(
                    "dense flat").mark(f"check-{number}")  # fmt: skip
            said = ui.label().classes("rnl-said").mark(f"said-{number}")
        self._say(said, lesson, number)

        async def answer() -> None:
            await run.io_bound(self.model.try_answer, lesson, number, given.value)
            self._say(said, lesson, number)
            self.done.clear()
            with self.done:
                self._progress(lesson)

        if not exercise.choices:
            given.on("keydown.enter", answer)

    @staticmethod
    def _field(exercise: Exercise, number: int) -> Any:
        if exercise.choices:
            return ui.radio(dict(exercise.choices)).props("inline dense").mark(f"answer-{number}")
        field = ui.input(placeholder="a number").props(
            f'dense outlined suffix="{exercise.unit}" aria-label="Your answer"'
        )
        return field.classes("rnl-number").mark(f"answer-{number}")

    def _say(self, said: ui.label, lesson: Lesson, number: int) -> None:
        words = self.model.said.get((lesson.key, number), "")
        right = (lesson.key, number) in self.model.solved
        said.text = words
        said.classes(replace="rnl-said " + ("rn-good" if right else "rn-bad"))

    async def _act(self, do: Do, _: object = None) -> None:
        try:
            await run.io_bound(do.act, self.session)
        except RovernavError as error:
            refuse(str(error))
            return
        self.session.go(do.tab)
