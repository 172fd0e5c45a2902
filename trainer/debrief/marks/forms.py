"""Evaluation forms: what assessors and peers think of a run, beside the program's marks.

``trainer exercise form`` writes a blank one, as a page or as TOML. ``trainer debrief --form`` keeps
filled ones beside the recording, drill.forms.toml beside drill.trainer, and shows them together.
A form has the exercise's own measures, how the crew worked together, and the whole run.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from markupsafe import Markup

from trainer.config.files import (
    ConfigError,
    Position,
    nearest,
    number_problems,
    parse_toml,
    quote,
    read_text,
    renew_file,
    text_if_there,
    toml_value,
)
from trainer.config.schema import (
    Choice,
    Quantity,
    Text,
    optional,
    read_record,
    required,
    within,
)
from trainer.debrief.marks.scoring import Scorecard, formula_of
from trainer.report.html import fill_page, paragraph, table
from trainer.session.past.plan import Plan

FORM_SCHEMA: Final = "form/1"
FORMS_SCHEMA: Final = "forms/1"
FORMS_SUFFIX: Final = ".forms.toml"  # ends the name of the file
ASSESSOR_KIND, PEER_KIND = "assessor", "peer"
MARK_FIELD: Final = Quantity("-", within(0, 100), "marks")
WHOLE_RUN_NAME: Final = "The whole run"
# what a program cannot judge: STCW A-I/12, 8.4, asks that it be looked at
CREW_WORK_NAMES: Final = (
    "Usual procedures",
    "Orders repeated and reported",
    "Told each other what they saw",
    "Helped who had too much to do",
)


@dataclass(frozen=True, kw_only=True)
class FormHeading:
    """Who judges what, and what he says in words."""

    exercise: str = required(Text(79, "title of the exercise"))
    kind: str = required(Choice((ASSESSOR_KIND, PEER_KIND), "who judges"))
    by: str = required(Text(60, "name of who judges"))
    on: str = required(Text(40, "day"))
    satisfied: str | None = optional(
        Choice(("yes", "no"), "whether it was done safely and effectively; of an assessor")
    )
    remark: str | None = optional(Text(500, "in words"))


@dataclass(frozen=True, kw_only=True)
class EvaluationForm(FormHeading):
    """A filled form."""

    marks: Mapping[str, float]  # 0 to 100 by name


@dataclass(frozen=True)
class ComparedMark:
    """The marks of one thing by program and forms; None: it has none."""

    name: str
    program: float | None
    marks: tuple[float | None, ...]
    assessors: tuple[float, ...]  # those marks that assessors gave

    @property
    def mean(self) -> float | None:
        """Return the assessors' mean; a peer's mark is shown, and does not count in it."""
        return math.fsum(self.assessors) / len(self.assessors) if self.assessors else None

    @property
    def spread(self) -> float | None:
        """Return how far the assessors' largest mark is from their smallest; None under two."""
        return max(self.assessors) - min(self.assessors) if len(self.assessors) > 1 else None


def judged_names(plan: Plan) -> tuple[str, ...]:
    """Return what a form asks marks of."""
    return (*(rule.score.name for rule in plan.scores), *CREW_WORK_NAMES, WHOLE_RUN_NAME)


def form_page(plan: Plan, kind: str) -> str:
    """Return the blank form as a page to be printed."""
    criteria = {rule.score.name: formula_of(rule) for rule in plan.scores}
    return fill_page(
        "form.html",
        "debrief.css",
        title=plan.title,
        kind=kind,
        briefing=plan.briefing,
        rows=[(name, criteria.get(name, "")) for name in judged_names(plan)],
    )


def form_text(plan: Plan, kind: str) -> str:
    """Return the blank form as TOML; what is not filled in is left out."""
    lines = [
        f"# Evaluation form, filled in for trainer debrief --form: {kind}",
        f"schema = {toml_value(FORM_SCHEMA)}",
        f"exercise = {toml_value(plan.title)}",
        f"kind = {toml_value(kind)}",
        'by = ""         # your name',
        'on = ""         # day, as 2026-11-25',
    ]
    if kind == ASSESSOR_KIND:
        lines.append('# satisfied = "yes"  # or "no": done safely and effectively')
    lines += ['# remark = ""', "", "[marks]  # 0 to 100; leave out what you did not see"]
    return "\n".join([*lines, *(f"# {toml_value(name)} = " for name in judged_names(plan)), ""])


def read_form(path: Path, plan: Plan) -> EvaluationForm:
    """Return a filled form; ConfigError if it is wrong, or of another exercise."""
    text = read_text(path)
    try:
        return _form_of(parse_toml(text, path.name), Position(path.name, ""), plan)
    except ConfigError as wrong:
        raise ConfigError(*number_problems(wrong.problems, text, path.name)) from None


def _form_of(table: dict[str, Any], position: Position, plan: Plan) -> EvaluationForm:
    """Return the form of a file's table, of the exercise of a plan; ConfigError."""
    if (schema := table.pop("schema", None)) != FORM_SCHEMA:
        raise ConfigError(position.wrong("schema", schema, f"must be {quote(FORM_SCHEMA)}"))
    form = _form(table, position)
    if form.exercise != plan.title:
        advice = f"the recording is of {quote(plan.title)}"
        raise ConfigError(position.wrong("exercise", form.exercise, advice))
    names = judged_names(plan)
    inside = position.inside("marks")
    problems = [
        inside.wrong(name, mark, f"nothing of that name is judged{nearest(name, names)}")
        for name, mark in form.marks.items()
        if name not in names
    ]
    if problems:
        raise ConfigError(*problems)
    return form


def _form(table: Mapping[str, Any], position: Position) -> EvaluationForm:
    """Return the form of a table; ConfigError."""
    marks = table.get("marks", {})
    if not isinstance(marks, dict) or not marks:
        raise ConfigError(position.problem("[marks]: has no mark"))
    inside = position.inside("marks")
    read = {name: MARK_FIELD.read(name, value, inside) for name, value in marks.items()}
    return EvaluationForm(**vars(read_record(FormHeading, table, position, ("marks",))), marks=read)


def forms_path(recording: Path) -> Path:
    """Return where the filled forms of a recording are kept: beside it."""
    return recording.with_name(f"{recording.stem}{FORMS_SUFFIX}")


def read_forms(recording: Path) -> tuple[EvaluationForm, ...]:
    """Return the forms kept beside a recording; ConfigError if they cannot be read."""
    path = forms_path(recording)
    text = text_if_there(path)
    if text is None:
        return ()
    rows = parse_toml(text, path.name).get("forms", [])
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise ConfigError(f"{path.name}: forms: must be tables [[forms]]")
    return tuple(_form(row, Position(path.name, f"forms[{i}]")) for i, row in enumerate(rows))


def with_forms(
    kept: Sequence[EvaluationForm], files: Sequence[Path], plan: Plan
) -> tuple[EvaluationForm, ...]:
    """Return kept and filled forms; a person's later one replaces the earlier."""
    filled = [read_form(path, plan) for path in files]
    return tuple({(each.kind, each.by): each for each in (*kept, *filled)}.values())


def write_forms(recording: Path, forms: Sequence[EvaluationForm]) -> None:
    """Write the forms beside a recording, whole or not at all; ConfigError if that fails."""
    path = forms_path(recording)
    lines = ["# Filled forms: trainer debrief --form", f"schema = {toml_value(FORMS_SCHEMA)}"]
    for form in forms:
        lines += ["", "[[forms]]"]
        for name, value in vars(form).items():
            if value is not None and name != "marks":
                lines.append(f"{name} = {toml_value(value)}")
        lines.append("[forms.marks]")
        lines += [f"{toml_value(name)} = {toml_value(mark)}" for name, mark in form.marks.items()]
    renew_file(path, "\n".join([*lines, ""]))


def compare_forms(forms: Sequence[EvaluationForm], card: Scorecard) -> list[ComparedMark]:
    """Return the marks of all forms beside the program's, where a form has any."""
    program: dict[str, float | None] = {
        each.name: each.marks if each.earned is None else each.earned for each in card.scores
    }
    program[WHOLE_RUN_NAME] = card.total
    judged = {name for form in forms for name in form.marks}
    names = [*(each.name for each in card.scores), *CREW_WORK_NAMES, WHOLE_RUN_NAME]
    return [
        ComparedMark(
            name,
            program.get(name),
            tuple(form.marks.get(name) for form in forms),
            tuple(
                form.marks[name]
                for form in forms
                if form.kind == ASSESSOR_KIND and name in form.marks
            ),
        )
        for name in names
        if name in judged
    ]


def form_words(forms: Sequence[EvaluationForm]) -> Iterator[str]:
    """Yield what those who filled in a form have said beside marks."""
    for form in forms:
        safe = {"yes": "done safely and effectively.", "no": "not done safely and effectively."}
        said = f"{safe.get(form.satisfied or '', '')} {form.remark or ''}".strip()
        if said:
            yield f"{form.by}, {form.kind}, {form.on}: {said}"


def compared_table(forms: Sequence[EvaluationForm], card: Scorecard) -> Markup:
    """Return the marks of those who filled in a form, beside the program's."""
    heads = ("judged", "program", *(f"{each.by}, {each.kind}" for each in forms))
    rows = [
        tuple(map(_cell, (each.name, each.program, *each.marks, each.mean, each.spread)))
        for each in compare_forms(forms, card)
    ]
    words = [paragraph(sentence) for sentence in form_words(forms)]
    return table((*heads, "assessors' mean", "spread"), rows) + Markup().join(words)


def compared_lines(forms: Sequence[EvaluationForm], card: Scorecard) -> Iterator[str]:
    """Yield the same in a line for each thing that was judged, for a terminal."""
    for each in compare_forms(forms, card):
        marks = [f"{form.by} {_cell(mark)}" for form, mark in zip(forms, each.marks, strict=True)]
        told = f"{each.name}: program {_cell(each.program)}; {', '.join(marks)}"
        yield f"{told} (mean {_cell(each.mean)}, spread {_cell(each.spread)})"
    yield from form_words(forms)


def _cell(value: str | float | None) -> str:
    if isinstance(value, str):
        return value
    return "-" if value is None else f"{value:.0f}"
