"""The design of a study: the order of conditions, the steps of a session, scores."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

import numpy as np

from pointbrush.errors import BadInputError, ConflictError
from pointbrush.teamwork.studies import Session
from pointbrush.values.study import Condition, QuestionItem, Questionnaire, Study, StudyStep

SCALES = Path(__file__).parent / "scales.yaml"


def conditions_of(study: Study, number: int) -> tuple[str, ...]:
    """Return the names of the conditions of participant ``number`` (from 1), in order."""
    names = [each.name for each in study.conditions]
    if study.design == "between":
        block, place = divmod(number - 1, len(names))
        order = _shuffled(study, block) if study.order == "random" else range(len(names))
        return (names[order[place]],)
    random = study.order == "random"
    order = _shuffled(study, number) if random else latin_row(len(names), number - 1)
    return tuple(names[n] for n in order)


def latin_row(count: int, row: int) -> list[int]:
    """Return a row of Williams's square, in which each condition follows each other equally often.

    It has ``count`` rows, or twice as many for an odd ``count``.
    """
    zigzag = [(n + 1) // 2 if n % 2 else (count - n // 2) % count for n in range(count)]
    found = [(n + row) % count for n in zigzag]
    return found[::-1] if count % 2 and (row // count) % 2 else found


def _shuffled(study: Study, block: int) -> Sequence[int]:
    random = np.random.default_rng([study.seed, block])
    order: list[int] = random.permutation(len(study.conditions)).tolist()
    return order


def plan(study: Study, session: Session) -> list[StudyStep]:
    """Return the steps of a session; raises ConflictError if the study's file has changed."""
    known = {each.name: each for each in study.conditions}
    unknown = [name for name in session.conditions if name not in known]
    if unknown:
        raise ConflictError(f"conditions: the study no longer has {unknown[0]!r}")
    steps = [StudyStep("consent", study.consent)] if study.consent else []
    for condition in map(known.__getitem__, session.conditions):
        steps.append(StudyStep("instructions", condition.instructions, condition))
        for task in sorted(study.tasks, key=lambda each: not each.practice):
            read = StudyStep("instructions", task.instructions, condition, task)
            steps += [read, replace(read, kind="practice" if task.practice else "task")]
        steps += _questionnaires(study, "condition", condition)
    steps += [*_questionnaires(study, "study", None), StudyStep("done")]
    named = partial(replace, title=study.title, count=len(steps))
    return [named(step, number=number) for number, step in enumerate(steps)]


def step_of(study: Study, session: Session) -> StudyStep:
    """Return the current step of a session."""
    steps = plan(study, session)
    return steps[min(session.step, len(steps) - 1)]


def copy_key(step: StudyStep) -> int:
    """Return the number of the step with the copy that a step shows; instructions show the next."""
    return step.number + (step.kind == "instructions")


def _questionnaires(study: Study, after: str, condition: Condition | None) -> list[StudyStep]:
    asked = StudyStep("questionnaire", condition=condition)
    return [
        replace(asked, questionnaire=replace(each, items=items_of(each)))
        for each in study.questionnaires
        if each.after == after
    ]


def items_of(questionnaire: Questionnaire) -> tuple[QuestionItem, ...]:
    """Return the items of a questionnaire, or the published items of its scoring if it has none."""
    return questionnaire.items or _scales()[questionnaire.scoring]


@cache
def _scales() -> dict[str, tuple[QuestionItem, ...]]:
    """Return the published items by scoring."""
    import yaml
    from pydantic import TypeAdapter  # slow to import

    items = TypeAdapter(dict[str, tuple[QuestionItem, ...]])
    return {"own": (), **items.validate_python(yaml.safe_load(SCALES.read_text("utf-8")))}


def require_answers(step: StudyStep, answers: Sequence[int]) -> None:
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
