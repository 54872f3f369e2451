"""`rovernav teach`: a neural driver learnt by imitation."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ._console import print_json, progress_bar, say, say_files
from ._files import claim_folder
from ._options import Json, Out
from ._workers import Place


def teach(
    recipe: Annotated[str, Parameter(help="Recipe YAML, or a shipped one: headings-v1.")],
    /,
    *,
    out: Out = Path("rovernav-teach"),
    place: Place | None = None,
    json: Json = False,
) -> int:
    """Teach a neural driver to imitate a planner that knows only what the rover has sensed.

    Finished rounds are kept in the folder: the same command goes on after a crash, to the same
    bits. Writes driver.safetensors, to be driven with --controller.

    Example: rovernav teach headings-v1 --out driver
    """
    from ..learn import Lesson, read_recipe
    from ..learn import teach as run
    from ..nets import save_network, weights_sha256

    whole = read_recipe(recipe)
    claim_folder(out)
    lessons: list[Lesson] = []
    with (place or Place()).executor() as executor, progress_bar("teaching") as update:

        def on_event(lesson: Lesson) -> None:
            lessons.append(lesson)
            within = 0.7 * lesson.share if lesson.doing == "driving" else 0.7 + 0.3 * lesson.share
            words = f"round {lesson.round} of {lesson.rounds}, {lesson.doing}"
            update((lesson.round - 1 + within) / lesson.rounds, words)

        network = run(whole, out, executor=executor, on_event=on_event)
    path = out / "driver.safetensors"
    save_network(network, path)
    rounds = {lesson.round: lesson for lesson in lessons}
    report = {
        "rounds": whole.rounds,
        "patterns": lessons[-1].patterns if lessons else None,
        "loss": lessons[-1].loss if lessons else None,
        "reached_in_practice": [rounds[k].reached for k in sorted(rounds)],
        "weights_sha256": weights_sha256(network),
        "files": [path],
    }
    if json:
        print_json(report)
        return 0
    for number, lesson in rounds.items():
        drives = f"{lesson.reached:.0%} of the drives reached their goal"
        if lesson.reached != lesson.reached:  # the drives were kept from before
            drives = "its drives were there already"
        say(f"Round {number}: {drives}, {lesson.patterns:,} patterns, "
            f"cross-entropy {lesson.loss:.3f}.")  # fmt: skip
    if not rounds:
        say("All rounds were there already.")
    say_files([path])
    return 0
