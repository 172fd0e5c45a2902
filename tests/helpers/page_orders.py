"""What the pages know of order words, made of the tables of the session.

python -m helpers.page_orders, from the folder of the tests, writes it among the pages' scripts.
"""

import json
from typing import Final

from helpers.document_tables import roles_with
from trainer.io.orders.table import FORMS, WORD_SETS, Form, heading_word, spellings, word_of
from trainer.io.orders.words import ANEW_ORDERS, CLASS_LINE, ORDER_WORDS, OrderWord
from trainer.session.crew.manning import REPEATING_ROLES, WORDS_AXIS
from trainer.web.modules import ASSETS_FOLDER

PAGE: Final = ASSETS_FOLDER / "js" / "model" / "order-table.js"
HEAD: Final = """\
// Order words, as the session's own tables have them: python -m helpers.page_orders makes this.

/** @typedef {{ obeyer: string, inReplay: boolean, afterEnd: boolean, roles: string[] }} Rule */
"""


def script() -> str:
    """Return the module: rules and heads of orders, and whose an order to the crew is."""
    words = REPEATING_ROLES[WORDS_AXIS]
    addressed = {axis: roles for axis, roles in REPEATING_ROLES.items() if axis != WORDS_AXIS}
    return "\n".join(
        (
            HEAD,
            _table("Who obeys an order word, and when.", "Record<string, Rule>", "ORDERS", rules()),
            _table(
                "The order that is meant, where it is not the first word.",
                *("Record<string, string>", "HEADS", heads()),
            ),
            _table(
                "Orders after which nothing of their moment stands.",
                "string[]",
                "ANEW",
                ANEW_ORDERS,
            ),
            _table("Who repeats what the crew is told in words.", "string[]", "CREW", words),
            _table(
                "Who repeats an order to the crew, by its axis.",
                *("Record<string, string[]>", "ADDRESSED", addressed),
            ),
        )
    )


def rules() -> dict[str, object]:
    """Return the rule of each order word that the pages ask for."""
    return {name: _rule(word) for name, word in sorted(ORDER_WORDS.items())}


def heads() -> dict[str, str]:
    """Return the order's name by the words at its head, where these are not its name.

    `course left 10` and `course left to 045` have one head: both are read as `course`.
    """
    forms = [form for form in FORMS if not form.refusal]
    names: dict[str, set[str]] = {}
    for form in forms:
        names.setdefault(heading_word(form), set()).add(word_of(form))
    found: dict[str, set[str]] = {}
    for form in forms:
        head, name = heading_word(form), word_of(form)
        if name != head:
            for key in [head] if len(names[head]) == 1 else _long_heads(form):
                found.setdefault(key, set()).add(name)
    return {key: name for key, (name, *others) in sorted(found.items()) if not others}


def write() -> None:
    """Renew the module."""
    PAGE.write_text(script(), encoding="utf-8")


def _long_heads(form: Form) -> list[str]:
    """Return the head of a form with each word that may be its second."""
    second = form.pattern.split()[1].strip("[]")
    words = {word for _, word in spellings(WORD_SETS.get(second, second))}
    return [f"{heading_word(form)} {word}" for word in sorted(words)]


def _rule(word: OrderWord) -> dict[str, object]:
    gates = {"inReplay": word.in_replay, "afterEnd": word.after_end}
    of_pages = [role for role in roles_with(word.name) if role != CLASS_LINE]
    return {"obeyer": word.obeyer.value, **gates, "roles": of_pages}


def _table(says: str, kind: str, name: str, content: object) -> str:
    """Return a constant of the module, an entry of a table in each line."""
    text = json.dumps(content)
    if isinstance(content, dict):
        lines = [f"  {json.dumps(key)}: {json.dumps(each)}," for key, each in content.items()]
        text = "\n".join(("{", *lines, "}"))
    return f"/** {says} @type {{{kind}}} */\nexport const {name} = {text};\n"


if __name__ == "__main__":
    write()
