"""The first lesson: why two bits fail."""

from __future__ import annotations

from functools import partial

from . import _lesson_facts as facts
from ._lesson_presets import drive_in, train_paper
from ._lessons import Do, Exercise, Lesson, Step

_ENDS = (
    ("reached", "It reaches the goal"),
    ("collided", "It runs into the obstacle"),
    ("timed_out", "It runs out of time"),
)

TWO_BITS = Lesson(
    key="why-two-bits-fail",
    title="Why two bits fail",
    minutes=20,
    question="The paper's rover passes its obstacle. Why does it hit the mirror image of it?",
    steps=(
        Step(
            "Train the paper's network",
            (
                "The network of the paper has two inputs. x is 1 when nothing stands on the "
                "straight line to the goal. y is 1 when the rover is off the line from start to "
                "goal. Each is a single bit.",
                "Its two outputs say how far to step along the line and across it. Train it with "
                "the paper's rule and watch the error fall.",
            ),
            (Do("Train it", "Train", train_paper),),
            (
                Exercise(
                    "After how many epochs is every error below 0.01?",
                    partial(facts.epochs),
                    "Let the training end by itself, then read the epoch above the network.",
                    "Right. The paper gives no such number: it never says when it stopped.",
                ),
            ),
        ),
        Step(
            "Drive it",
            (
                "Now it drives. An obstacle stands across the line, mostly above it. Nobody told "
                "the rover: it learns of it through x alone.",
                "Play the drive and watch the line of sight: red and dashed while the obstacle is "
                "in the way, green once it is not.",
            ),
            (
                Do(
                    "Drive it in the paper's scene",
                    "Drive",
                    lambda s: drive_in(s, "bassil-v1", "train"),
                ),
            ),
            (
                Exercise(
                    "At which step is the rover highest, and turns down to the goal?",
                    facts.turn,
                    "Stop the playback at the top of the track and read the step under Now.",
                    "Right: seven steps up, then down, as in the paper's figure.",
                ),
            ),
        ),
        Step(
            "Mirror the obstacle",
            (
                "Turn the obstacle upside down: what stood above the line stands below it now. For "
                "a rover with eyes that is no harder. First say what will happen, then drive.",
            ),
            (
                Do(
                    "Drive it with the mirrored obstacle",
                    "Drive",
                    lambda s: drive_in(s, "bassil-mirrored-v1", "train"),
                ),
            ),
            (
                Exercise(
                    "How does it end?",
                    partial(facts.outcome, "mirrored"),
                    "Drive it and look at the table of tracks.",
                    "Right. It steps into the obstacle on the very side where most of it stands.",
                    choices=_ENDS,
                ),
            ),
        ),
        Step(
            "Ask it why",
            (
                "Click the first point of the track, or go to step 0 and press Ask about this "
                "step. Do it in both scenes and compare what the network was given.",
                "The bars show how each hidden neuron and the bias add up to an output. They are "
                "the same in both scenes, to the last digit.",
            ),
            (
                Do("The paper's scene again", "Drive", lambda s: drive_in(s, "bassil-v1", "train")),
                Do(
                    "The mirrored one again",
                    "Drive",
                    lambda s: drive_in(s, "bassil-mirrored-v1", "train"),
                ),
            ),
            (
                Exercise(
                    "What are x, y at the start of the mirrored scene?",
                    partial(facts.bits, "mirrored"),
                    "Is the straight line to the goal free? Is the rover off the line?",
                    "Right, and they are the same in the paper's scene.",
                    choices=tuple((c, c) for c in ("0, 0", "0, 1", "1, 0", "1, 1")),
                ),
                Exercise(
                    "To which side does the first step go, in both scenes?",
                    partial(facts.first_move, "mirrored"),
                    "The second output is the step across the line; look at its sum.",
                    "Right: up, because it was taught [0, 0] → [1, 1]. The same inputs can only "
                    "give the same answer, and here one answer cannot be right for both.",
                    choices=(("up", "Up"), ("down", "Down"), ("neither", "Straight on")),
                ),
            ),
        ),
        Step(
            "No training can mend it",
            (
                "Two bits have four values, so a network can only give four answers. More neurons, "
                "more epochs or another rule do not change that: what is missing is in the inputs.",
                "How much it matters: over many random rectangles across the line, how many does "
                "this network pass? The notebook of this lesson counts them; 2,000 are enough to "
                "see it.",
            ),
            (),
            (
                Exercise(
                    "Your guess, or the notebook's count: what percentage does it pass? "
                    "(5 points to either side are right)",
                    facts.reached_share,
                    "The obstacle lies above the line as often as below it, and the rover always "
                    "tries the upper side.",
                    "Right: less than half.",
                    slack=5.0,
                    unit="%",
                ),
            ),
        ),
        Step(
            "What a driver needs to see",
            (
                "The shipped neural driver has 64 numbers all round: how far it is free in each "
                "direction, as far as its beams have seen. Let both drive the mirrored scene.",
                "Ask it why at a bend: the rose shows the free way and the directions it chose "
                "from.",
            ),
            (
                Do(
                    "Both in the mirrored scene",
                    "Drive",
                    lambda s: drive_in(s, "bassil-mirrored-v1", "train", "neural"),
                ),
            ),
            (
                Exercise(
                    "How does the neural driver end?",
                    facts.neural_outcome,
                    "Press the button and wait for the green or red mark.",
                    "Right. It is not cleverer, it sees more.",
                    choices=_ENDS,
                ),
            ),
        ),
    ),
)
