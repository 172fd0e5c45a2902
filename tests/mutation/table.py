"""The table of what has found faults of one place."""

from collections import Counter
from collections.abc import Iterator, Sequence

from mutation.places import ROOMS, FaultKind
from mutation.trials import Drawn, Trial, one_line, room_of


def in_words(drawn: Drawn, trials: Sequence[Trial]) -> Iterator[str]:
    """Yield the table of what has found the faults, and those that nothing has found."""
    share = 100.0 * (1.0 - drawn.executed / drawn.places)
    yield (
        f"{drawn.places} places drawn, {drawn.executed} of them on lines that sessions execute "
        f"({share:.0f} % are not)"
    )
    yield f"{'':20}{'faults':>8}{'sessions':>10}{'tests':>8}{'nothing':>9}{'told':>6}"
    groups = [*FaultKind, *ROOMS, ""]
    for group in groups:
        name = group.value if isinstance(group, FaultKind) else group
        those = [each for each in trials if name in (each.kind, room_of(each.file), "")]
        counts = count_finders(those)
        yield (
            f"{name or 'all':20}{len(those):8}{counts['sessions']:10}{counts['tests']:8}"
            f"{counts['nothing']:9}{counts['told']:6}"
        )
    for each in trials:
        if each.unfound:
            yield (
                f"NOTHING FINDS {each.file}:{each.line} {each.function}: "
                f"`{one_line(each.before)}` -> `{one_line(each.after)}`"
            )


def count_finders(trials: Sequence[Trial]) -> Counter[str]:
    """Return how many faults sessions find, tests, nothing; how many are told."""
    return Counter(
        (
            "sessions"
            if each.sessions
            else "tests"
            if each.tests
            else "told"
            if each.equivalent
            else "nothing"
        )
        for each in trials
    )
