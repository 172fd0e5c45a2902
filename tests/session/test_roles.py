"""Who may order what, and who sees and hears what."""

import pytest
from helpers.orders import read_order

from trainer.config.files import ConfigError
from trainer.io.orders.grammar import Order
from trainer.io.orders.table import FORMS, heading_word
from trainer.io.orders.words import CREW_ROLES
from trainer.session.stations.channels import CHANNELS, TELETYPE_CHANNEL
from trainer.session.stations.roles import (
    EVENT_KINDS,
    ROLES,
    STRANGER_ROLE,
    Access,
    channel_refusal,
    hears_kind,
    read_tokens,
    refusal,
)

GRAMMAR = sorted({form.name or heading_word(form) for form in FORMS if not form.refusal})
SHIP = {"stern", "bow", "planes", "planes-mode", "depth", "periscope"}
WATER = {"blow", "emergency", "vent", "negative", "flood", "pump", "drain", "hover", "compressor"}
WATER |= {"trim"}
PLANT = {"isolate", "open", "hydraulic", "bus", "breaker", "loads", "ventilation", "fight"}
HELM = {"rudder", "course", "course-by", "course-to", "speed", "turns", "rpm", "bell"}
HELM |= {"rudder-mode"}
SAYS = {"report", "aye", "ready", "relief"}
OFFICER = {"surface", "dive", "order", "tell", "belay"}
OWN = {
    "instructor": set(GRAMMAR),
    "helm": HELM | SAYS | {"have"},
    "planes": SHIP | SAYS | {"have"},
    "pilot": HELM | SHIP | SAYS | {"have"},
    "ballast": WATER | PLANT | SAYS | {"have"},
    "diving": SHIP | WATER | PLANT | SAYS | {"have", "rudder-mode"} | OFFICER,
    "deck": SAYS | {"order", "belay"},
    "observer": {"mark"},
    "visitor": {"lever", "restart"},
    "scope": {"scope", "mark"} | SAYS,
}
OWN["trainee"] = set().union(*(OWN[name] for name in CREW_ROLES)) | {
    *("run", "freeze", "step", "time", "again", "backtrack", "next", "end", "quit", "autopilot"),
    *("debrief", "demonstrate", "hint", "ghost", "predictor"),
}
ALL = {
    *("role", "help", "status", "briefing", "log", "alerts", "ack", "history"),
    *("subscribe", "unsubscribe", "detach", "who", "name"),
}
TRAINEES = sorted(set(ROLES) - {"instructor", "class"})


def test_a_role_gives_the_orders_of_the_table_and_no_others() -> None:
    faults = [
        f"{role}: {name} is {'refused' if told else 'obeyed'}"
        for role, own in OWN.items()
        for name in GRAMMAR
        for told in [refusal(ROLES[role], Order(name, 0.0, "", name))]
        if (told is None) is not (name in own | ALL)
    ]

    assert OWN
    assert not faults


@pytest.mark.parametrize(
    ("role", "line", "why"),
    [
        (
            "ballast",
            "rudder left 5",
            "the rudder is the helm's or the pilot's; you have the ballast",
        ),
        (
            "helm",
            "stern planes rise 5",
            "or the diving officer's; you have the helm",
        ),
        ("helm", "freeze", '"freeze" is the instructor\'s; you have the helm'),
        (
            "diving",
            "autopilot on",
            "the autopilot as a whole is the instructor's; you are the diving officer",
        ),
        (
            "observer",
            "bell stop",
            "the engine is the helm's or the pilot's; you are an observer",
        ),
        (
            "visitor",
            "planes auto",
            "the planes station's or the pilot's or the diving officer's; you are a visitor",
        ),
        (
            "deck",
            "order pitch 3 up",
            "you are the officer of the deck, who orders course, depth and speed alone",
        ),
        ("deck", "belay words", "who orders course, depth and speed alone"),
        ("deck", "order clear all", "who orders course, depth and speed alone"),
        ("deck", "depth 80", "or the diving officer's; you are the officer of the deck"),
        ("deck", "tell rig for red", "the diving officer's; you are the officer of the deck"),
        ("visitor", "freeze", '"freeze" is the instructor\'s; you are a visitor'),
        ("planes", "lever dive 8", "the lever is a visitor's; you have the planes"),
        (
            "planes",
            "casualty rudder-stuck",
            "is the instructor's; you have the planes",
        ),
    ],
)
def test_a_refusal_says_whose_it_is(role: str, line: str, why: str) -> None:
    refused = refusal(ROLES[role], read_order(line))
    assert refused
    assert refused.reason.endswith(why)


@pytest.mark.parametrize(
    "line",
    [
        *("order course left 045", "order course steady", "order depth 60", "order speed 8"),
        *("order periscope", "order clear depth", "belay", "belay course", "depth 60 aye"),
    ],
)
def test_the_officer_of_the_deck_orders_course_depth_and_speed(line: str) -> None:
    assert refusal(ROLES["deck"], read_order(line)) is None


@pytest.mark.parametrize("line", ["rudder auto", "stern auto", "bow planes auto", "course auto"])
def test_the_autopilot_is_given_surfaces_one_by_one_by_whose_they_are(line: str) -> None:
    role = "helm" if line.startswith(("rudder", "course")) else "planes"

    assert refusal(ROLES[role], read_order(line)) is None


def test_a_line_that_owes_a_token_may_only_say_who_it_is_ask_for_help_or_go() -> None:
    free = {name for name in GRAMMAR if refusal(STRANGER_ROLE, Order(name, 0.0, "", name)) is None}

    assert free == {"role", "help", "detach"}
    assert all(channel_refusal(STRANGER_ROLE, channel) for channel in CHANNELS)
    assert not any(hears_kind(STRANGER_ROLE, kind) for kind in EVENT_KINDS)


def test_every_channel_of_a_role_exists_and_the_instructor_has_all() -> None:
    there = {*CHANNELS, TELETYPE_CHANNEL}

    assert set(ROLES["instructor"].channels) == there
    assert all(set(role.channels) <= there for role in ROLES.values())


@pytest.mark.parametrize("channel", ["motion", "sea", "casualties", "ledger"])
def test_the_truth_is_for_the_instructor_alone(channel: str) -> None:
    assert channel_refusal(ROLES["instructor"], channel) is None
    refused = [channel_refusal(ROLES[role], channel) for role in TRAINEES]
    assert all(each and channel in each.reason for each in refused)


def test_the_class_hears_where_a_boat_is_and_tells_of_the_others_by_the_instructors_word() -> None:
    orders = {
        name for name in GRAMMAR if refusal(ROLES["class"], Order(name, 0.0, "", name)) is None
    }
    assert orders == {"contact"} | ALL
    assert ROLES["class"].channels == ("motion", "time")
    words = Access(tokens={"": "anchor", "instructor": "chief"})
    assert [words.admits("class", word) for word in ("anchor", "chief")] == [False, True]
    assert Access(tokens={"": "anchor"}).admits("class", "anchor")


HEARERS = {
    ("exercise", "watch", "refused", "trouble", "never heard of"): {"instructor"},
    ("order",): {"instructor", "observer"},
    ("time", "moment", "station"): set(ROLES) - {"class"},
}


@pytest.mark.parametrize("kinds", HEARERS)
def test_each_kind_of_news_is_told_to_its_hearers_and_to_nobody_else(kinds: tuple[str]) -> None:
    for kind in kinds:
        hearing = {name for name, role in ROLES.items() if hears_kind(role, kind)}
        assert hearing == HEARERS[kinds], kind


def test_a_word_of_the_class_is_refused_since_it_comes_by_the_instructors() -> None:
    with pytest.raises(ConfigError, match="instructor=WORD: say that"):
        read_tokens(("anchor", "class=lesson"))
