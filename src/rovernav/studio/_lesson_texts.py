"""The three lessons."""

from __future__ import annotations

from functools import partial

from . import _lesson_facts as facts
from ._lesson_presets import set_up, train_paper
from ._lesson_two_bits import TWO_BITS
from ._lessons import Do, Exercise, Lesson, Step

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
            (Do("Train without momentum", "Train", lambda s: train_paper(s, momentum=0.0)),),
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
            (Do("Train with momentum 0.5", "Train", lambda s: train_paper(s, momentum=0.5)),),
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
                Do("Momentum 0.9, tolerance 0.01", "Train", lambda s: train_paper(s, momentum=0.9)),
                Do(
                    "Momentum 0.9, tolerance 0.001",
                    "Train",
                    lambda s: train_paper(s, momentum=0.9, tolerance=0.001),
                ),
                Do(
                    "Momentum 0.5, tolerance 0.001",
                    "Train",
                    lambda s: train_paper(s, momentum=0.5, tolerance=0.001),
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
                    lambda s, eta=eta: train_paper(
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
            (Do("Rate 0.05, momentum 0.5", "Train", lambda s: train_paper(s, eta=0.05)),),
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
                    lambda s: set_up(s, rule="paper", momentum=0.0),
                ),
                Do(
                    "Set up the textbook's rule",
                    "Train",
                    lambda s: set_up(s, rule="textbook", momentum=0.0),
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
                Do("Paper's rule, momentum 0.5", "Train", lambda s: train_paper(s, rule="paper")),
                Do(
                    "Textbook's rule, momentum 0.5",
                    "Train",
                    lambda s: train_paper(s, rule="textbook"),
                ),
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
                    lambda s: train_paper(
                        s, momentum=0.0, tolerance=0.001, epochs=facts.MANY, speed="full"
                    ),
                ),
                Do(
                    "Textbook's rule, no momentum, 0.001",
                    "Train",
                    lambda s: train_paper(
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
