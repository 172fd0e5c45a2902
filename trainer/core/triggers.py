"""Casualties that begin when the state meets a condition, without Python in the tick.

Armed triggers are constants of the scheme; the state remembers which of them are spent.
"""

from trainer.core.kernel import Record, part
from trainer.core.onset import begin


@part
def holds(scheme: Record, trigger: int, state: Record) -> bool:
    """Return whether the condition of a trigger is met by the state."""
    m = scheme[0]
    value = state[0].whole[int(m.trigger_place[trigger])]
    excess = m.trigger_sense[trigger] * (value - m.trigger_threshold[trigger])
    return excess > 0.0 or (excess == 0.0 and m.trigger_strict[trigger] == 0.0)


@part
def fire_triggers(scheme: Record, state: Record) -> None:
    """Begin the casualties whose conditions the last state meets.

    A trigger is spent when it has fired; one that fires again is renewed when its condition has
    become false. One that finds no free slot waits for it.
    """
    m = scheme[0]
    s = state[0]
    for i in range(m.trigger_kind.size):
        if m.trigger_kind[i] == 0.0:
            return  # those armed come first
        bit = 1 << i
        spent = int(s.triggers_spent) & bit
        met = holds(scheme, i, state)
        if met and spent == 0:
            kind = int(m.trigger_kind[i])
            s.triggers_spent += bit * begin(kind, m.trigger_amount[i], m.trigger_ticks[i], state)
        elif spent != 0 and not met and m.trigger_again[i] != 0.0:
            s.triggers_spent -= bit
