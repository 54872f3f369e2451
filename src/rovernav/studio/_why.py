"""Why did it do that? One step of a drive, told in words, bars and numbers."""

from __future__ import annotations

import math
from html import escape

import numpy as np

from ..control import Headings, Why
from ..core import F64, Outcome
from ..nets import Explanation
from ..show import end_words
from ..sim import DriveState

MOST_BARS = 9
"""Hidden units that get a bar of their own; the rest are added up in one."""
MOST_OUTPUTS = 4
WIDE, BAR = 460, 17


def result_words(before: float, after: DriveState, *, ended: bool) -> list[str]:
    """What came of a command: how far it went, and how the drive ended if it did.

    Args:
        before: Distance driven before the step [m].
        after: The state after it.
        ended: Whether it was the last step.
    """
    outcome = Outcome(int(after.rovers.outcome[0]))
    moved = float(after.rovers.odometry[0]) - before
    words = [f"The rover moved {moved:.2f} m."]
    if ended and outcome is not Outcome.DRIVING:
        words.append(f"That ended the drive: it {end_words(outcome)}.")
    if outcome is Outcome.COLLIDED:
        words.append("The step was cut off where it met an obstacle or forbidden ground.")
    words.append("No safety check stands between this controller and the motors; none spoke up.")
    return words


def why_html(why: Why, came_of_it: list[str]) -> str:
    """The whole answer."""
    parts = [_list(why.words), '<div class="rn-title">What came of it</div>', _list(came_of_it)]
    if why.headings is not None:
        parts += ['<div class="rn-title">Directions it chose from</div>', rose(why)]
    if why.network is not None:
        parts.append(
            '<div class="rn-title">What each hidden neuron added</div>'
            '<div class="rn-note">weight × activation, the bias, and their sum: the output'
            f"{'' if why.headings is None else ', here of the direction it chose'}.</div>"
        )
        parts += [contributions(why, k) for k in _outputs(why)]
    parts.append(inputs_table(why))
    return "".join(parts)


def contributions(why: Why, output: int) -> str:
    """Bars of what adds up to one output."""
    network = why.network
    assert network is not None
    terms = bar_terms(network, output)
    name = why.output_names[output] if output < len(why.output_names) else f"output {output}"
    total, answer = float(network.sums[output]), float(network.outputs[output])
    most = max(1e-12, *(abs(value) for _, value, _ in terms), abs(total))
    middle, reach = 236.0, 118.0
    rows = []
    for i, (words, value, exact) in enumerate([*terms, (f"= {name}", total, repr(total))]):
        y = i * BAR + 4
        last = i == len(terms)
        wide = reach * abs(value) / most
        x = middle if value >= 0 else middle - wide
        colour = "var(--rn-ink)" if last else f"var(--rn-{'blue' if value >= 0 else 'orange'})"
        rows.append(
            f'<g><title>{escape(exact)}</title><text x="108" y="{y + 12}" text-anchor="end" '
            f'font-size="11.5" {_bold(last)}>{escape(words)}</text>'
            f'<rect x="{x:.1f}" y="{y + 2}" width="{max(wide, 0.8):.1f}" height="{BAR - 5}" '
            f'fill="{colour}"/><text x="{WIDE - 4}" y="{y + 12}" text-anchor="end" '
            f'font-size="11.5" class="rn-num" {_bold(last)}>{value:+.4f}</text></g>'
        )
    high = (len(terms) + 1) * BAR + 8
    line = f'<line x1="{middle}" y1="2" x2="{middle}" y2="{high - 4}" stroke="var(--rn-muted)"/>'
    note = "" if abs(answer - total) < 1e-12 else f"after its activation {answer:+.4f}"
    return (
        f'<svg viewBox="0 0 {WIDE} {high}" width="100%" role="img" aria-label="What adds up to '
        f'{escape(name)}">{line}{"".join(rows)}</svg><div class="rn-note">{note}</div>'
    )


def bar_terms(network: Explanation, output: int) -> list[tuple[str, float, str]]:
    """Words, value and exact value of each bar, the largest hidden units first, the bias last."""
    row = network.contributions[output]
    hidden = row[:-1]
    below = network.activations[-2] if len(network.activations) > 1 else network.inputs
    letter = "h" if len(network.activations) > 1 else "x"
    order = np.argsort(-np.abs(hidden), kind="stable")
    shown = order if len(order) <= MOST_BARS else order[: MOST_BARS - 1]
    shown = np.sort(shown) if len(order) <= MOST_BARS else shown
    terms = [
        (f"{letter}{j} = {below[j]:.3f}", float(hidden[j]),
         f"{float(hidden[j])!r} = activation {float(below[j])!r} × weight")
        for j in shown.tolist()
    ]  # fmt: skip
    rest = [j for j in order.tolist() if j not in set(shown.tolist())]
    if rest:
        value = float(hidden[rest].sum())
        terms.append((f"{len(rest)} others", value, repr(value)))
    return [*terms, ("bias", float(row[-1]), repr(float(row[-1])))]


def rose(why: Why) -> str:
    """The directions around the rover, as long as they are favoured; up is straight ahead."""
    headings = why.headings
    assert headings is not None
    free = _free(why, headings)
    middle, reach = 150.0, 120.0
    parts = [
        f'<circle cx="{middle}" cy="{middle}" r="{reach}" fill="var(--rn-field)" '
        'stroke="var(--rn-line)"/>'
    ]
    if free is not None:
        ring = " ".join(
            f"{middle - reach * f * math.sin(a):.1f},{middle - reach * f * math.cos(a):.1f}"
            for a, f in zip(*free, strict=True)
        )
        parts.append(
            f'<polygon points="{ring}" fill="var(--rn-sky)" fill-opacity=".3" '
            'stroke="var(--rn-sky)"/>'
        )
    largest = float(headings.share.max())
    for k, (angle, share) in enumerate(zip(headings.angles, headings.share, strict=True)):
        length = reach * float(share) / largest
        colour = "vermilion" if k == headings.chosen else "blue"
        parts.append(
            f'<line x1="{middle}" y1="{middle}" x2="{middle - length * math.sin(angle):.1f}" '
            f'y2="{middle - length * math.cos(angle):.1f}" stroke="var(--rn-{colour})" '
            f'stroke-width="5" stroke-linecap="round"><title>{math.degrees(angle):.0f}°: '
            f"{share:.1%}</title></line>"
        )
    a = headings.angle
    tip = (middle - (reach + 14) * math.sin(a), middle - (reach + 14) * math.cos(a))
    parts.append(
        f'<line x1="{middle}" y1="{middle}" x2="{tip[0]:.1f}" y2="{tip[1]:.1f}" '
        'stroke="var(--rn-vermilion)" stroke-width="1.6" stroke-dasharray="5 4"/>'
        f'<path d="M{middle - 6} {middle + 7}l6 -16l6 16z" fill="var(--rn-ink)"/>'
    )
    keys = [("vermilion", "taken; dashed: steered"), ("blue", "other directions")]
    if free is not None:
        keys.append(("sky", "free way on its map"))
    legend = "".join(
        f'<rect x="300" y="{40 + 24 * i}" width="12" height="12" fill="var(--rn-{c})"/>'
        f'<text x="318" y="{50 + 24 * i}" font-size="11">{w}</text>'
        for i, (c, w) in enumerate(keys)
    )
    return (
        f'<svg viewBox="0 0 {WIDE} 300" width="100%" role="img" '
        f'aria-label="Directions, up is ahead">{"".join(parts)}{legend}</svg>'
    )


def _free(why: Why, headings: Headings) -> tuple[F64, F64] | None:
    """Directions and free shares that a network with rays all round was given."""
    shares = [value for name, value, _ in why.inputs if name.startswith("free_")]
    if len(shares) < 4:
        return None
    zero = float(headings.angles[0])  # heading 0 and ray 0 both point at the goal
    return zero + 2 * math.pi * np.arange(len(shares)) / len(shares), np.array(shares)


def inputs_table(why: Why) -> str:
    """Inputs by name; for a network also how strongly the outputs answer to each."""
    if not why.inputs:
        return ""
    network = why.network
    head = "<th>input</th><th class=n>value</th>"
    asked = () if network is None else network.asked[:MOST_OUTPUTS]
    head += "".join(f"<th class=n>d {escape(_name(why, k))}</th>" for k in asked)
    order = range(len(why.inputs))
    note = ""
    if len(why.inputs) > 12 and network is not None:
        strength = np.abs(network.sensitivity).max(axis=0)
        order = np.argsort(-strength, kind="stable")[:10].tolist()
        note = f"The ten of {len(why.inputs)} inputs that this output answers to most. "
    rows = []
    for i in order:
        name, value, unit = why.inputs[i]
        cells = f"<td>{escape(name)}</td><td class=n>{value:.4g} {'' if unit == '1' else unit}</td>"
        if network is not None:
            cells += "".join(
                f"<td class=n>{network.sensitivity[r, i]:+.4f}</td>" for r in range(len(asked))
            )
        rows.append(f"<tr>{cells}</tr>")
    if asked:
        note += "d: by how much the output would rise per unit of that input, here."
    return (
        '<div class="rn-title">What it was given</div>'
        f'<table class="rn-table"><tr>{head}</tr>{"".join(rows)}</table>'
        f'<div class="rn-note">{note}</div>'
    )


def _outputs(why: Why) -> list[int]:
    assert why.network is not None
    if why.headings is not None:
        return [why.headings.chosen]
    return list(range(min(len(why.network.outputs), MOST_OUTPUTS)))


def _name(why: Why, output: int) -> str:
    return why.output_names[output] if output < len(why.output_names) else f"output {output}"


def _list(words: list[str] | tuple[str, ...]) -> str:
    return f"<ul class='rn-why'>{''.join(f'<li>{escape(each)}</li>' for each in words)}</ul>"


def _bold(yes: bool) -> str:
    return 'font-weight="700"' if yes else ""
