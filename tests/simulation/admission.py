"""Words that a session asks for, and who comes in by which."""

from collections.abc import Sequence
from dataclasses import replace
from random import Random
from typing import Final

from simulation.script import Act, Life, Player, Script, Way

# As `--token` has them: a word for all roles that have none of their own, and those of a role.
WORDS: Final = (
    ("tide-4711-mast",),
    ("tide-4711-mast", "instructor=keel-0815-lead"),
    ("tide-4711-mast", "helm=oak-2207-wheel", "planes=fin-3310-brass"),
    ("instructor=keel-0815-lead", "helm=oak-2207-wheel", "ballast=tide-4711-mast"),
)
WRONG_WORDS: Final = ("", "tide-4711-mas", "tide-4711-mast2", "TIDE-4711-MAST", "guess")
WORDED_SHARE: Final = 0.15  # [-] of scripts
RIGHT_SHARE: Final = 0.7  # [-] of players say the right word
GUESSES: Final = (0, 0, 1, 3)  # more of a player who says a wrong one
GUESS_PACE_S: Final = 0.4
# No orders, and the word is to be hidden all the same.
MISSPELT: Final = ("rolle {role} {word}", "{role} {word}", "role {role}:{word}", "tell {word}")
STRANGERS_WORDS: Final = ("help", "detach")  # that who is nobody yet may say


def word_of(tokens: Sequence[str], role: str) -> str:
    """Return the word by which a role comes in, "" where nobody may take it."""
    words = dict(each.rpartition("=")[::2] for each in tokens)
    return words.get(role, words.get("", ""))


def is_admitted(tokens: Sequence[str], role: str, word: str) -> bool:
    """Return whether a word admits to a role."""
    return bool(word) and word == word_of(tokens, role)


def secrets_of(tokens: Sequence[str]) -> tuple[bytes, ...]:
    """Return the words themselves."""
    return tuple(each.rpartition("=")[2].encode() for each in tokens)


def ask_words(seed: int, script: Script) -> Script:
    """Return a script whose session asks some seeds for words."""
    dice = Random(f"{seed}/words")  # noqa: S311  no secrets
    if dice.random() >= WORDED_SHARE:
        return script
    tokens = dice.choice(WORDS)
    lives = tuple(give_words(dice, life, tokens) for life in script.lives)
    return replace(script, tokens=tokens, lives=lives)


def give_words(dice: Random, life: Life, tokens: Sequence[str]) -> Life:
    """Return a process whose players each know a word, the right one or another."""
    return replace(life, players=tuple(_give_word(dice, each, tokens) for each in life.players))


def _give_word(dice: Random, player: Player, tokens: Sequence[str]) -> Player:
    right = word_of(tokens, player.role)
    if player.way is Way.CABLE or (right and dice.random() < RIGHT_SHARE):
        return replace(player, token="" if player.way is Way.CABLE else right)
    others = [each.rpartition("=")[2] for each in tokens]
    token = dice.choice([word for word in (*WRONG_WORDS, *others) if word != right])
    words = [dice.choice(MISSPELT).format(role=player.role, word=others[0])]
    words += dice.choice(GUESSES) * [f"role {player.role} {token or 'guess'}"]
    guesses = tuple(Act(GUESS_PACE_S, each) for each in words)
    visits = tuple(replace(each, acts=(*guesses, *each.acts)) for each in player.visits)
    return replace(player, token=token, visits=visits)
