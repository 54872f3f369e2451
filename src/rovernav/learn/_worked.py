"""The paper's worked example one step at a time, each number beside the printed one.

Bassil 2012, section 6.3. What was printed is quoted as printed, with its slips; the notes say what
is meant. Numbers in full precision come from `worked_example`.
"""

from __future__ import annotations

from collections.abc import Iterator

from ..core import value
from ._paper import W1, W2, WorkedExample, worked_example

PRINTED = {
    "net of h0": "0.1",
    "net of h1": "0.21",
    "net of h2": "0.69",
    "h0": "0.524",
    "h1": "0.552",
    "h2": "0.665",
    "O0": "0.83",
    "O1": "1.74995",
    "error of O0": "0.17",
    "error of O1": '"0. 74994"',
    "new W00 of the outputs": "0.13227",
    "new W01 of the outputs": "0.05346",
    "new W10 of the outputs": "0.83176",
    "new W00 of the hidden layer": "0.17",
}
"""What the paper printed, by quantity, letter by letter."""
ETA = 0.25


@value
class WorkedRow:
    """One number of the worked example.

    Attributes:
        name: The quantity.
        formula: How it comes about, with numbers put in.
        printed: What the paper printed; empty where it printed nothing.
        number: The number in full precision.
    """

    name: str
    formula: str
    printed: str
    number: float


@value
class WorkedStep:
    """One step of the worked example.

    Attributes:
        title: What is computed.
        note: What a reader must know, among it the paper's slips.
        rows: Its numbers.
    """

    title: str
    note: str
    rows: tuple[WorkedRow, ...]


def worked_steps(rule: str = "paper") -> tuple[WorkedStep, ...]:
    """The worked example in order: forward, error, outputs' weights, hidden weights.

    Args:
        rule: ``paper`` sends errors back through the updated weights, ``textbook`` through the old.

    Raises:
        SettingError: There is no such rule.
    """
    example = worked_example(rule)
    forward = (
        WorkedStep(
            title="Sums into the hidden neurons",
            note="The input is x = 0, y = 0, so only the biases remain.",
            rows=tuple(_nets(example)),
        ),
        WorkedStep(
            title="Outputs of the hidden neurons",
            note="Sigmoid, 1/(1 + e^-t). The paper cut its digits off, it did not round them.",
            rows=tuple(
                _row(f"h{i}", f"1/(1 + e^-{net:g})", float(h))
                for i, (net, h) in enumerate(zip(example.hidden_nets, example.hidden, strict=True))
            ),
        ),
        WorkedStep(
            title="Outputs",
            note="Linear. The paper prints O1 as 1.74995 and two lines later as 1.74994; "
            "both come from the hidden outputs cut to three digits.",
            rows=tuple(_outputs(example)),
        ),
        WorkedStep(
            title="Errors",
            note="Desired minus actual, desired [1, 1]. The paper lost the sign of the second: "
            "it goes on with -0.74994.",
            rows=tuple(
                _row(f"error of O{k}", f"1 - {o:.6g}", float(e))
                for k, (o, e) in enumerate(zip(example.outputs, example.errors, strict=True))
            ),
        ),
    )
    new = WorkedStep(
        title="New weights of the outputs",
        note="Old weight plus eta times source times error, eta 0.25; "
        'the paper prints three of them, then "...etc".',
        rows=tuple(_new_w2(example)),
    )
    back = WorkedStep(
        title="Error sums of the hidden neurons", note=_BACK[rule], rows=tuple(_back(example, rule))
    )
    hidden = WorkedStep(
        title="New weights of the hidden layer",
        note="Old weight plus eta times input times h(1 - h) times the error sum. "
        "With x = y = 0 only the biases change; the paper prints the one that does not.",
        rows=tuple(_new_w1(example)),
    )
    after = WorkedStep(
        title="Outputs with the new weights",
        note="The same input again: both outputs have moved towards 1. Not in the paper.",
        rows=tuple(
            _row(f"O{k} after", "forward pass again", float(o))
            for k, o in enumerate(example.outputs_after)
        ),
    )
    return (*forward, *((new, back) if rule == "paper" else (back, new)), hidden, after)


_BACK = {
    "paper": "Through the weights that were just updated, as the paper's numbers and its listing "
    "do. Its formula names W10 twice where it means W00 and W10; it prints the factors, "
    "(0.17*0.13227) + (-0.74994*0.83176), but no sum.",
    "textbook": "Through the old weights: the exact gradient. The paper does otherwise.",
}


def _row(name: str, formula: str, number: float) -> WorkedRow:
    return WorkedRow(name=name, formula=formula, printed=PRINTED.get(name, ""), number=number)


def _nets(example: WorkedExample) -> Iterator[WorkedRow]:
    for i, (x, y, bias) in enumerate(W1):
        net = float(example.hidden_nets[i])
        yield _row(f"net of h{i}", f"0*{x:g} + 0*{y:g} + 1*{bias:g}", net)


def _outputs(example: WorkedExample) -> Iterator[WorkedRow]:
    for k, weights in enumerate(W2):
        sources = [f"{h:.6g}" for h in example.hidden] + ["1"]
        terms = " + ".join(f"{s}*{w:g}" for s, w in zip(sources, weights, strict=True))
        yield _row(f"O{k}", terms, float(example.outputs[k]))


def _new_w2(example: WorkedExample) -> Iterator[WorkedRow]:
    sources = [*map(float, example.hidden), 1.0]
    for k, weights in enumerate(W2):
        for j, (old, source) in enumerate(zip(weights, sources, strict=True)):
            formula = f"{old:g} + {ETA}*{source:.6g}*{example.errors[k]:.6g}"
            yield _row(f"new W{k}{j} of the outputs", formula, float(example.w2[k, j]))


def _back(example: WorkedExample, rule: str) -> Iterator[WorkedRow]:
    through = example.w2 if rule == "paper" else W2
    for i, total in enumerate(example.back_sums):
        terms = " + ".join(
            f"{error:.6g}*{row[i]:.6g}" for error, row in zip(example.errors, through, strict=True)
        )
        yield _row(f"error sum of h{i}", terms, float(total))


def _new_w1(example: WorkedExample) -> Iterator[WorkedRow]:
    for i, (weights, h, total) in enumerate(
        zip(W1, example.hidden, example.back_sums, strict=True)
    ):
        for j, (old, source) in enumerate(zip(weights, (0, 0, 1), strict=True)):
            formula = f"{old:g} + {ETA}*{source}*{h:.6g}*(1 - {h:.6g})*{total:.6g}"
            yield _row(f"new W{i}{j} of the hidden layer", formula, float(example.w1[i, j]))
