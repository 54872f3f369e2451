from __future__ import annotations

import re

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.core import SettingError
from rovernav.learn import PRINTED, RULES, worked_example, worked_steps

NUMBER = re.compile(r"[-]?\d+(?:\.\d+)?")


@pytest.mark.parametrize("rule", RULES)
def test_every_formula_gives_its_number(rule: str) -> None:
    rows = [row for step in worked_steps(rule) for row in step.rows if "forward" not in row.formula]
    assert len(rows) == 3 + 3 + 2 + 2 + 8 + 3 + 9
    for row in rows:
        formula = row.formula.replace("e^-", "np.e**-").replace("+ -", "- ")
        assert_allclose(eval(formula, {"np": np}), row.number, rtol=0, atol=2e-5, err_msg=row.name)


def test_what_was_printed_stands_beside_its_number() -> None:
    rows = {row.name: row for step in worked_steps() for row in step.rows}
    printed = {name: row.printed for name, row in rows.items() if row.printed}
    assert printed == PRINTED
    for name, text in printed.items():
        (number,) = map(float, NUMBER.findall(text.replace(" ", "")))
        sign = -1.0 if name == "error of O1" else 1.0  # the sign that the paper lost
        assert_allclose(sign * number, rows[name].number, rtol=0, atol=2e-3, err_msg=name)


@pytest.mark.parametrize("rule", RULES)
def test_the_numbers_are_those_of_the_worked_example(rule: str) -> None:
    example = worked_example(rule)
    steps = {step.title: [row.number for row in step.rows] for step in worked_steps(rule)}
    assert steps["New weights of the outputs"] == example.w2.ravel().tolist()
    assert steps["New weights of the hidden layer"] == example.w1.ravel().tolist()
    assert steps["Error sums of the hidden neurons"] == example.back_sums.tolist()
    assert steps["Outputs with the new weights"] == example.outputs_after.tolist()
    order = list(steps)
    updated_first = order.index("New weights of the outputs") < order.index(
        "Error sums of the hidden neurons"
    )
    assert updated_first == (rule == "paper")


def test_an_unknown_rule_is_named() -> None:
    with pytest.raises(SettingError, match="unknown rule 'papr'; did you mean 'paper'"):
        worked_steps("papr")
