"""The three lessons."""

from __future__ import annotations

from functools import partial
from typing import Any

from . import _lesson_facts as facts
from ._lessons import Do, Exercise, Lesson, Step

_PAPER: dict[str, Any] = {
    "table": "bassil-v1", "hidden": "3", "rule": "paper", "eta": 0.25, "momentum": 0.5,
    "tolerance": 0.01, "epochs": 5000, "order": "cyclic", "weights": "paper", "speed": "watch",
}  # fmt: skip


def _train(session: Any, **changes: Any) -> None:
    session.train.preset({**_PAPER, **changes})
    session.train.start()


def _set_up(session: Any, **changes: Any) -> None:
    session.train.preset({**_PAPER, **changes})


def _drive(session: Any, scene: str, *keys: str) -> None:
    session.drive.set_world(session.drive.flat[scene])
    session.drive.choose(keys)
    session.drive.drive()


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
            (Do("Train it", "Train", _train),),
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
                    lambda s: _drive(s, "bassil-v1", "train"),
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
                    lambda s: _drive(s, "bassil-mirrored-v1", "train"),
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
                Do("The paper's scene again", "Drive", lambda s: _drive(s, "bassil-v1", "train")),
                Do(
                    "The mirrored one again",
                    "Drive",
                    lambda s: _drive(s, "bassil-mirrored-v1", "train"),
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
                    lambda s: _drive(s, "bassil-mirrored-v1", "train", "neural"),
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

RATE = Lesson(
    key="learning-rate-and-momentum",
    title="Learning rate and momentum",
    minutes=20,
    question="How large may a step of learning be, and what does momentum add?",
    steps=(
        Step(
            "One step at a time",
            (
                "Back-propagation changes each weight by the learning rate times its share of the "
                "error. Momentum repeats a share of the weight's last change.",
                "Begin with the paper's rate of 0.25 and no momentum. The error falls quickly at "
                "first, then creeps.",
            ),
            (Do("Train without momentum", "Train", lambda s: _train(s, momentum=0.0)),),
            (
                Exercise(
                    "How many epochs until every error is below 0.01?",
                    partial(facts.epochs, momentum=0.0),
                    "Set the speed to Full speed and let it end by itself.",
                    "Right. Now see what momentum does to that.",
                ),
            ),
        ),
        Step(
            "A little momentum",
            (
                "Momentum 0.5 repeats half of the last change. Where all changes point the same "
                "way, they add up to twice the step.",
            ),
            (Do("Train with momentum 0.5", "Train", lambda s: _train(s, momentum=0.5)),),
            (
                Exercise(
                    "How many epochs now?",
                    partial(facts.epochs, momentum=0.5),
                    "The curve of the run before stays on the chart, so that you can compare.",
                    "Right: more than five times faster.",
                ),
            ),
        ),
        Step(
            "More is better? It depends",
            (
                "With momentum 0.9 steps add up to ten times the size. Try it down to a tolerance "
                "of 0.01, and then of 0.001.",
            ),
            (
                Do("Momentum 0.9, tolerance 0.01", "Train", lambda s: _train(s, momentum=0.9)),
                Do(
                    "Momentum 0.9, tolerance 0.001",
                    "Train",
                    lambda s: _train(s, momentum=0.9, tolerance=0.001),
                ),
                Do(
                    "Momentum 0.5, tolerance 0.001",
                    "Train",
                    lambda s: _train(s, momentum=0.5, tolerance=0.001),
                ),
            ),
            (
                Exercise(
                    "Which momentum needs the fewest epochs for a tolerance of 0.01?",
                    partial(facts.best_momentum, 0.01),
                    "You have all three numbers now.",
                    "Right.",
                    choices=(("0", "0"), ("0.5", "0.5"), ("0.9", "0.9")),
                ),
                Exercise(
                    "And for 0.001?",
                    partial(facts.best_momentum, 0.001),
                    "Run 0.5 and 0.9 down to 0.001 and compare.",
                    "Right: heavy momentum gets near quickly, and then swings around the place.",
                    choices=(("0", "0"), ("0.5", "0.5"), ("0.9", "0.9")),
                ),
            ),
        ),
        Step(
            "Too far",
            (
                "A step that is too large does not arrive: it jumps over the valley and lands "
                "higher on the other side, the next one higher still. That is divergence.",
                "Without momentum, double the rate again and again and watch the error. The "
                "training stops by itself before the numbers overflow, and keeps the last weights "
                "that were finite.",
            ),
            tuple(
                Do(
                    f"Rate {eta:g}",
                    "Train",
                    lambda s, eta=eta: _train(
                        s, momentum=0.0, eta=eta, epochs=facts.MANY, speed="full"
                    ),
                )
                for eta in facts.RATES
            ),
            (
                Exercise(
                    "Which is the smallest of these rates that diverges?",
                    partial(facts.first_diverging, 0.0),
                    "A rate that never gets below the tolerance but stays finite has not diverged.",
                    "Right. Just below it training neither ends nor diverges: it jumps to and fro.",
                    choices=tuple((f"{eta:g}", f"{eta:g}") for eta in facts.RATES),
                ),
                Exercise(
                    "And with momentum 0.9?",
                    partial(facts.first_diverging, 0.9),
                    "Set the momentum to 0.9 in the Train tab and try the rates again.",
                    "Right: here momentum damps the jumps to and fro, because they point in "
                    "opposite directions. It is not the same as a larger rate.",
                    choices=tuple((f"{eta:g}", f"{eta:g}") for eta in facts.RATES),
                ),
            ),
        ),
        Step(
            "Slow and sure",
            ("A small rate always gets there, and you wait for it. Try 0.05 with momentum 0.5.",),
            (Do("Rate 0.05, momentum 0.5", "Train", lambda s: _train(s, eta=0.05)),),
            (
                Exercise(
                    "How many epochs?",
                    partial(facts.epochs, eta=0.05),
                    "Tolerance 0.01, momentum 0.5.",
                    "Right: about eleven times as many as with 0.25.",
                ),
            ),
        ),
    ),
)

RULES = Lesson(
    key="the-papers-rule",
    title="The paper's rule against the textbook's",
    minutes=20,
    question="The paper's listing is not quite back-propagation. Does it matter?",
    steps=(
        Step(
            "Find the difference",
            (
                "Both rules first change the weights of the outputs. To get the error of a hidden "
                "neuron they then send the outputs' errors back through those weights. The "
                "textbook uses the weights as they were; the paper's listing uses the ones it has "
                "just changed.",
                "In the Train tab, open Worked example and step through it. Do it with each rule.",
            ),
            (
                Do(
                    "Set up the paper's rule",
                    "Train",
                    lambda s: _set_up(s, rule="paper", momentum=0.0),
                ),
                Do(
                    "Set up the textbook's rule",
                    "Train",
                    lambda s: _set_up(s, rule="textbook", momentum=0.0),
                ),
            ),
            (
                Exercise(
                    "The error sum of h0 by the paper's rule, to three decimals?",
                    partial(facts.back_sum, "paper"),
                    "error(O0) × new W00 + error(O1) × new W10: 0.1694 × 0.1322 - 0.7517 × 0.8313.",
                    "Right.",
                    slack=0.001,
                ),
                Exercise(
                    "And by the textbook's?",
                    partial(facts.back_sum, "textbook"),
                    "The same sum with the old weights 0.11 and 0.93.",
                    "Right: the two differ by about a tenth here.",
                    slack=0.001,
                ),
            ),
        ),
        Step(
            "Which one is the gradient?",
            (
                "A gradient can be checked without any theory: move one weight a little up and a "
                "little down, and see how much the error changes. The notebook does this for the "
                "bias of h0.",
            ),
            (),
            (
                Exercise(
                    "Which rule passes the check?",
                    facts.finite_difference,
                    "The gradient is about the network as it is, before anything was changed.",
                    "Right. The paper's rule errs by an amount in proportion to the learning rate.",
                    choices=(("paper", "The paper's"), ("textbook", "The textbook's")),
                ),
            ),
        ),
        Step(
            "So it must learn worse?",
            ("Train both to a tolerance of 0.01 with momentum 0.5, then without.",),
            (
                Do("Paper's rule, momentum 0.5", "Train", lambda s: _train(s, rule="paper")),
                Do("Textbook's rule, momentum 0.5", "Train", lambda s: _train(s, rule="textbook")),
            ),
            (
                Exercise(
                    "Epochs of the textbook's rule with momentum 0.5?",
                    partial(facts.epochs, rule="textbook"),
                    "Tolerance 0.01, rate 0.25.",
                    "Right.",
                ),
                Exercise(
                    "Which rule needed fewer?",
                    partial(facts.faster_rule, 0.5, 0.01),
                    "You found the paper's number in the other lessons.",
                    "Right. Being the exact gradient does not mean being faster: gradient descent "
                    "with finite steps is itself only a rule of thumb.",
                    choices=(("paper", "The paper's"), ("textbook", "The textbook's")),
                ),
            ),
        ),
        Step(
            "Not always",
            (
                "One table and one start prove nothing. Without momentum and down to 0.001 the "
                "order turns round.",
            ),
            (
                Do(
                    "Paper's rule, no momentum, 0.001",
                    "Train",
                    lambda s: _train(
                        s, momentum=0.0, tolerance=0.001, epochs=facts.MANY, speed="full"
                    ),
                ),
                Do(
                    "Textbook's rule, no momentum, 0.001",
                    "Train",
                    lambda s: _train(
                        s,
                        rule="textbook",
                        momentum=0.0,
                        tolerance=0.001,
                        epochs=facts.MANY,
                        speed="full",
                    ),
                ),
            ),
            (
                Exercise(
                    "Which rule needs fewer epochs now?",
                    partial(facts.faster_rule, 0.0, 0.001),
                    "Run both at full speed.",
                    "Right. Which rule wins depends on rate, momentum and tolerance; that both "
                    "learn the table does not.",
                    choices=(("paper", "The paper's"), ("textbook", "The textbook's")),
                ),
            ),
        ),
    ),
)

LESSONS = (TWO_BITS, RATE, RULES)
