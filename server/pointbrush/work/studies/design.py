"""The design of a study: the order of conditions, the steps of a session, published scales."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pointbrush.errors import BadInputError, ConflictError
from pointbrush.values.study import (
    Condition,
    QuestionItem,
    Questionnaire,
    StepKind,
    Study,
    StudyTask,
)

SUS = (
    "I think that I would like to use this system frequently.",
    "I found the system unnecessarily complex.",
    "I thought the system was easy to use.",
    "I think that I would need the support of a technical person to be able to use this system.",
    "I found the various functions in this system were well integrated.",
    "I thought there was too much inconsistency in this system.",
    "I would imagine that most people would learn to use this system very quickly.",
    "I found the system very cumbersome to use.",
    "I felt very confident using the system.",
    "I needed to learn a lot of things before I could get going with this system.",
)
"""System Usability Scale (Brooke 1996); every second item is reversed."""
TLX = (
    ("Mental demand: how mentally demanding was the task?", "Very low", "Very high"),
    ("Physical demand: how physically demanding was the task?", "Very low", "Very high"),
    ("Temporal demand: how hurried or rushed was the pace of the task?", "Very low", "Very high"),
    ("Performance: how successful were you in the task?", "Perfect", "Failure"),
    ("Effort: how hard did you have to work?", "Very low", "Very high"),
    ("Frustration: how insecure, discouraged or annoyed were you?", "Very low", "Very high"),
)
"""Scales of the NASA Task Load Index (Hart and Staveland 1988), used without weights."""
TLX_STEPS = 21


@dataclass(frozen=True, slots=True)
class PlannedStep:
    """A step; ``copy``: number of the step whose copy of the recording it shows, -1: none."""

    kind: StepKind
    text: str = ""
    condition: Condition | None = None
    task: StudyTask | None = None
    questionnaire: Questionnaire | None = None
    copy: int = -1


def conditions_of(study: Study, number: int) -> tuple[str, ...]:
    """Return the names of the conditions of participant ``number`` (from 1), in order."""
    names = [each.name for each in study.conditions]
    if study.design == "between":
        round_, place = divmod(number - 1, len(names))
        shuffled = study.order == "random"
        order = _shuffled(study.seed, round_, len(names)) if shuffled else range(len(names))
        return (names[order[place]],)
    if study.order == "random":
        return tuple(names[n] for n in _shuffled(study.seed, number, len(names)))
    return tuple(names[n] for n in latin_row(len(names), number - 1))


def latin_row(count: int, row: int) -> list[int]:
    """Return a row of Williams's square, in which each condition follows each other equally often.

    It has ``count`` rows, or twice as many for an odd ``count``.
    """
    zigzag = [(n + 1) // 2 if n % 2 else (count - n // 2) % count for n in range(count)]
    found = [(n + row) % count for n in zigzag]
    return found[::-1] if count % 2 and (row // count) % 2 else found


def _shuffled(seed: int, part: int, count: int) -> Sequence[int]:
    order: list[int] = np.random.default_rng([seed, part]).permutation(count).tolist()
    return order


def plan(study: Study, conditions: Sequence[str]) -> list[PlannedStep]:
    """Return the steps of a session; raises ConflictError if the study's file has changed."""
    known = {each.name: each for each in study.conditions}
    unknown = [name for name in conditions if name not in known]
    if unknown:
        raise ConflictError(f"conditions: the study no longer has {unknown[0]!r}")
    steps = [PlannedStep("consent", study.consent)] if study.consent else []
    for condition in map(known.__getitem__, conditions):
        steps.append(PlannedStep("instructions", condition.instructions, condition))
        for task in sorted(study.tasks, key=lambda each: not each.practice):
            shown = PlannedStep("instructions", task.instructions, condition, task)
            steps.append(replace(shown, copy=len(steps) + 1))
            steps.append(replace(steps[-1], kind="practice" if task.practice else "task"))
        steps += _questionnaires(study, "condition", condition)
    return [*steps, *_questionnaires(study, "study", None), PlannedStep("done")]


def _questionnaires(study: Study, after: str, condition: Condition | None) -> list[PlannedStep]:
    return [
        PlannedStep(
            "questionnaire",
            condition=condition,
            questionnaire=replace(each, items=items_of(each)),
        )
        for each in study.questionnaires
        if each.after == after
    ]


def items_of(questionnaire: Questionnaire) -> tuple[QuestionItem, ...]:
    """Return the items of a questionnaire, by default the published ones of its scoring."""
    if questionnaire.items:
        return questionnaire.items
    if questionnaire.scoring == "sus":
        low, high = "Strongly disagree", "Strongly agree"
        return tuple(
            QuestionItem(text=text, low=low, high=high, reversed=n % 2 == 1)
            for n, text in enumerate(SUS)
        )
    if questionnaire.scoring == "tlx":
        return tuple(
            QuestionItem(text=text, low=low, high=high, steps=TLX_STEPS) for text, low, high in TLX
        )
    return ()


def require_answers(step: PlannedStep, answers: Sequence[int]) -> None:
    """Raise BadInputError unless each item of a step has a valid answer."""
    items = step.questionnaire.items if step.questionnaire else ()
    if len(answers) != len(items):
        raise BadInputError(f"answers: expected {len(items)}, got {len(answers)}")
    for number, (item, answer) in enumerate(zip(items, answers, strict=True), 1):
        if answer > item.steps:
            raise BadInputError(f"answers: expected 1 to {item.steps} for item {number}")


def score(items: Sequence[QuestionItem], answers: Sequence[int]) -> float:
    """Return the mean of the answers, 0 to 100, with reversed items turned.

    It is the published score of the System Usability Scale, and that of the raw NASA-TLX.
    """
    shares = [(answer - 1) / (item.steps - 1) for item, answer in zip(items, answers, strict=True)]
    turned = [1 - s if item.reversed else s for item, s in zip(items, shares, strict=True)]
    return 100 * sum(turned) / max(1, len(turned))
