"""A station: what it may do on its line, what is answered there, what is handed on and logged."""

import functools
import gc
import math
import re
import threading
import weakref
from collections.abc import Callable

import pytest
from helpers.boats import start_bb2
from helpers.line import Line
from helpers.places import ROOT
from helpers.sessions import prompt_sender

from trainer.boat.boat import Boat
from trainer.io.lines import OverlongLine
from trainer.io.orders.grammar import Order, Refused
from trainer.io.orders.sentences import Message, order_sentence, parse_line, parse_sentence
from trainer.io.server import Server
from trainer.session.stations.roles import (
    FIRST_WAIT_S,
    FORGET_AFTER_S,
    MAX_MACHINES,
    MAX_WAIT_S,
    Access,
    GuessWaits,
)
from trainer.session.stations.station import (
    ORDERS_A_SECOND,
    ORDERS_AT_ONCE,
    Fact,
    News,
    Station,
    TokenGuesses,
)
from trainer.session.stations.subscriptions import PromptSender, Roster
from trainer.session.stations.view import Pace, StateReader
from trainer.session.time.ledger import Ledger

TOKEN = "Kx7-quietly-9"  # noqa: S105 not a secret
MANY = 10_000


NAME = "tcp 127.0.0.1:4711"


class Post:
    """A station with its line, its log and a boat that stands still."""

    def __init__(self, boat: Boat, access: Access) -> None:
        self.now = 0.0
        self.line = Line(NAME)
        self.log: list[tuple[str, str]] = []
        self.boat = boat
        self.sending = PromptSender(
            Roster(StateReader(boat, Ledger(0.5).summary)), lambda: self.now
        )
        self.station = Station(
            self.line,
            access,
            self.sending,
            lambda kind, text: self.log.append((kind, text)),
            lambda: self.now,
        )

    def type(self, *lines: str | OverlongLine) -> list[str]:
        """Type lines; return the texts of the orders handed on."""
        self.line.waiting += lines
        return [asked.order.text for asked in self.station.take(MANY)]

    def said(self) -> list[str]:
        """Return what the line was sent since the last time."""
        said, self.line.sent = self.line.sent, []
        return said

    def answer_to(self, line: str) -> str:
        """Return the one line that answers."""
        self.said()
        assert not self.type(line)
        (answer,) = self.said()
        return answer

    def offer(self, tick: int) -> None:
        state = self.boat.records.state.copy()
        state["tick"] = tick
        self.sending.offer(tick, state.tobytes(), Pace())


MakePost = Callable[..., Post]


@pytest.fixture(scope="module")
def boat() -> Boat:
    return start_bb2()


@pytest.fixture
def post(boat: Boat) -> MakePost:
    return lambda role=None, token="": Post(boat, Access(role, {"": token} if token else {}))


@pytest.fixture
def helm(post: MakePost) -> Post:
    return post("helm")


@pytest.fixture
def line(post: MakePost) -> Post:
    return post()


def test_a_station_and_its_line_are_gone_with_the_last_who_knows_them(boat: Boat) -> None:
    sending = prompt_sender(boat)
    line = Line(NAME)
    line.waiting = ["subscribe gauges", "nonsense", "role helm", "rudder left 5"]
    station = Station(line, Access(), sending, lambda *_: None)
    assert len(list(station.take(MANY))) == 1
    station.leave()
    gone = weakref.ref(station), weakref.ref(line)

    gc.disable()
    del station, line
    left = [each() for each in gone]
    gc.enable()

    assert left == [None, None]


# Orders


def test_an_order_of_the_role_is_handed_on_and_answered_where_it_came_from(helm: Post) -> None:
    helm.line.waiting += ["rudder left 5", "course 090"]

    first, second = helm.station.take(MANY)
    helm.station.answer(first, "left 5, by hand")
    helm.station.answer(second, Refused("no autopilot"))

    assert [first.order.name, second.order.name] == ["rudder", "course"]
    assert helm.said() == ["left 5, by hand", "? no autopilot"]
    assert helm.station.counts.orders == 2
    assert first.station.who == "helm at tcp 127.0.0.1:4711"


def test_an_order_outside_the_role_is_refused_logged_and_goes_no_further(post: MakePost) -> None:
    ballast = post("ballast")

    answer = ballast.answer_to("rudder left 5")

    why = "the rudder is the helm's or the pilot's; you have the ballast"
    assert answer == f"? {why}"
    assert ballast.log == [("refused", f"ballast at {NAME}: rudder left 5: {why}")]
    assert (ballast.station.counts.refused, ballast.station.counts.orders) == (1, 0)


def test_a_program_gets_its_tag_back_with_every_answer(helm: Post) -> None:
    helm.line.waiting += [
        order_sentence("rudder left 5", "17"),
        order_sentence("blow all", "18"),
        order_sentence("bell stop"),
    ]

    first, last = helm.station.take(MANY)
    helm.station.answer(first, "done", "one", "two")
    helm.station.answer(last, "done")

    heard = [(found.tag, *found.fields) for line in helm.said() if (found := parse_sentence(line))]
    whose = "main ballast is the ballast station's or the diving officer's; you have the helm"
    assert heard == [
        ("18", "no", whose),
        ("17", "say", "one"),
        ("17", "say", "two"),
        ("17", "ok", "done"),
        ("", "ok", "done"),
    ]


def test_a_line_that_is_no_order_is_answered_counted_and_logged(helm: Post) -> None:
    answer = helm.answer_to("ruder left 5")

    assert answer.startswith('? "ruder" is no order')
    assert helm.station.counts.bad == 1
    assert helm.log[0][0] == "refused"
    assert "ruder left 5" in helm.log[0][1]


def test_a_damaged_sentence_is_answered_as_a_sentence(post: MakePost) -> None:
    found = parse_sentence(post("helm").answer_to("$TRO,5,rudder left 5*00"))

    assert found
    assert (found.tag, found.fields[0]) == ("", "no")


def test_an_overlong_line_is_told_so_and_the_next_is_heard(helm: Post) -> None:
    handed_on = helm.type(OverlongLine(80), "rudder left 5")

    assert helm.said() == ["? longer than 80 characters; nothing done"]
    assert handed_on == ["rudder left 5"]


def test_blank_lines_and_comments_are_passed_over(helm: Post) -> None:
    assert not helm.type("", "   ", "# steady as she goes")
    assert not helm.said()
    assert helm.station.counts.bad == 0


def test_a_babbling_line_logs_twenty_entries_in_ten_seconds_and_then_their_number(
    helm: Post,
) -> None:
    for _ in range(100):
        helm.type("blah")
    assert len(helm.log) == 20

    helm.now = 10.0
    helm.type("rudder left 5")

    assert helm.log[20:] == [("refused", "80 more of the same, not written one by one")]
    helm.type("blah")
    assert len(helm.log) == 22
    assert helm.station.counts.bad == 101


def test_help_is_answered_at_the_station(helm: Post) -> None:
    assert not helm.type("help rudder")
    assert helm.said()[0] == "rudder, in full:"
    assert not helm.type(order_sentence("help rudder", "3"))
    answers = [found.fields[0] for line in helm.said() if (found := parse_sentence(line))]
    assert answers[0] == "say"
    assert answers[-1] == "ok"
    assert set(answers[:-1]) == {"say"}


def test_detach_says_goodbye_and_nothing_after_it_is_heard(helm: Post) -> None:
    assert not helm.type("detach", "rudder left 5")

    assert helm.said() == ["bye"]
    assert helm.station.leaving == "detached"


# Roles and tokens


def test_a_role_is_told_what_it_may_order_and_see_in_79_columns(line: Post) -> None:
    line.type("role diving")

    *powers, last = line.said()

    told = " ".join(powers)
    assert last == "you are the diving officer"
    assert "blow" in told
    assert "tanks" in told
    assert all(len(each) <= 79 for each in powers)


def test_a_role_is_said_once(line: Post) -> None:
    line.type("role helm")

    assert line.answer_to("role instructor") == "? you have the helm: a line keeps its role"
    assert line.station.role.name == "helm"


def test_where_a_token_is_asked_for_a_line_can_do_nothing_without(post: MakePost) -> None:
    line = post(token=TOKEN)
    line.offer(0)

    for order in ("rudder left 5", "status", "subscribe gauges", "subscribe events", "who"):
        assert line.answer_to(order) == "? say who you are first: role NAME TOKEN"
    assert "needs a token: --token WORD" in line.answer_to("role helm")
    line.station.tell(News(0, 0.0, "station", "somebody came"))
    assert not line.said()


def test_a_program_that_owes_a_token_is_told_no_fact(post: MakePost) -> None:
    line = post(token=TOKEN)
    line.type(order_sentence("status", "1"))
    line.said()
    has = News(0, 0.0, "exercise", "", Fact("has", "rudder,helm at local 1,"))

    line.station.note(has)
    assert not line.said()
    line.type(order_sentence(f"role helm {TOKEN}", "2"))
    line.said()
    line.station.note(has)
    assert line.said()


@pytest.mark.parametrize("guess", [TOKEN.lower(), TOKEN[:-1], TOKEN + "0", "x"])
def test_a_token_that_is_not_the_very_same_is_refused(post: MakePost, guess: str) -> None:
    line = post(token=TOKEN)

    assert line.answer_to(f"role helm {guess}") == "? wrong token"
    assert line.station.guesses.count == 1
    assert line.station.role.name == "stranger"


def test_after_a_wrong_token_every_order_is_answered_by_that(post: MakePost) -> None:
    line = post(token=TOKEN)
    line.type("role helm wrong")

    for order in ("subscribe teletype", "rudder left 5"):
        answer = line.answer_to(order)
        assert answer == "? wrong token: type role NAME TOKEN with the right one"
    line.type(f"role helm {TOKEN}")
    assert line.said()[-1] == "you have the helm"


@pytest.mark.parametrize(
    ("role", "says", "logged"),
    [
        ("planes", "you have the planes", "now has the planes"),
        ("pilot", "you have helm and planes (pilot)", "now has helm and planes (pilot)"),
        ("diving", "you are the diving officer", "now is the diving officer"),
        ("visitor", "you are a visitor", "now is a visitor"),
    ],
)
def test_each_role_is_told_in_its_own_words(line: Post, role: str, says: str, logged: str) -> None:
    line.type(f"role {role}")

    assert line.said()[-1] == says
    assert ("station", f"{NAME} {logged}") in line.log


def test_the_third_wrong_token_closes_the_line_and_the_right_one_comes_too_late(
    post: MakePost,
) -> None:
    line = post(token=TOKEN)

    line.type("role helm a", "role helm b", "role helm c", f"role helm {TOKEN}")

    assert line.said()[-1] == "? wrong token, the 3rd: this line is closed"
    assert line.station.leaving == "3 wrong tokens"
    assert line.station.role.name == "stranger"


@pytest.mark.parametrize(
    "line",
    [
        f"role helm {TOKEN}",
        f"role helm {TOKEN} please",
        f"role admiral {TOKEN}",
        f"rolle helm {TOKEN}",
        f"ROLE HELM {TOKEN}x",
        order_sentence(f"role helm {TOKEN}", "5"),
        f"$TRO,role helm {TOKEN}*00",
    ],
)
def test_no_answer_log_or_account_repeats_a_token(post: MakePost, line: str) -> None:
    station = post(token=TOKEN)

    station.type(line, line)

    told = [*station.said(), *(text for _, text in station.log), station.station.account()]
    assert told
    assert not [text for text in told if TOKEN.lower() in text.lower()]
    assert TOKEN not in repr(station.station._door)  # noqa: SLF001 what a traceback would show


class Machine:
    """A machine whose lines say tokens, at a door that keeps their answers back."""

    def __init__(self, boat: Boat) -> None:
        self.boat = boat
        self.now = 0.0
        self.waits = GuessWaits(lambda: self.now)

    def line(self, machine: str = "10.0.0.1") -> Post:
        """Return a new line from a machine."""
        delay = functools.partial(self.waits.count, machine)
        post = Post(self.boat, Access(None, {"": TOKEN}, delay=delay))
        post.station.guesses = TokenGuesses(lambda: self.now)  # one clock for all lines
        return post


@pytest.fixture
def machine(boat: Boat) -> Machine:
    return Machine(boat)


def test_the_answer_to_a_wrong_token_waits_and_is_in_the_log_at_once(machine: Machine) -> None:
    assert machine.line().answer_to("role helm a") == "? wrong token"
    machine.line().type("role helm a", "role helm b")
    late = machine.line()

    late.type("role helm a")

    assert not late.said()
    assert late.log[-1] == ("refused", f"stranger at {NAME}: role helm: wrong token")
    assert late.station.guesses.wait == FIRST_WAIT_S
    machine.now += FIRST_WAIT_S
    late.type()
    assert late.said() == ["? wrong token; answered after 1 s, because there were many"]
    assert late.station.guesses.wait == math.inf
    late.type(f"role helm {TOKEN}")
    assert late.said()[-1] == "you have the helm"


def test_a_line_that_waits_for_an_answer_guesses_no_more_and_is_let_go_when_it_hangs_up(
    machine: Machine,
) -> None:
    machine.line().type("role helm a", "role helm b", "role helm c")
    late = machine.line()

    late.type("role helm a", "role helm b", f"role helm {TOKEN}")

    assert late.said() == 2 * ["? not heard: wait for the answer to the wrong token"]
    assert (late.station.guesses.count, late.station.role.name) == (1, "stranger")
    assert not late.station.waiting  # nothing is left that would keep its place
    assert not late.station.allowance.held_up


def test_a_right_token_is_admitted_at_once_behind_any_number_of_wrong_ones(
    machine: Machine,
) -> None:
    for _ in range(200):
        machine.line().type("role helm a")

    for where in ("10.0.0.1", "10.0.0.2"):
        line = machine.line(where)
        line.type(f"role helm {TOKEN}")
        assert line.said()[-1] == "you have the helm"
    other = machine.line("10.0.0.2")
    assert other.answer_to("role helm a") == "? wrong token"  # its machine has guessed nothing


def test_the_third_wrong_token_closes_a_line_once_its_answer_is_given(machine: Machine) -> None:
    machine.waits.count("10.0.0.1")
    line = machine.line()
    line.type("role helm a", "role helm b", "role helm c")
    before: str = line.station.leaving
    machine.now += FIRST_WAIT_S

    line.type()

    assert line.said()[-1].startswith("? wrong token, the 3rd: this line is closed; answered after")
    assert (before, line.station.leaving) == ("", "3 wrong tokens")


def test_waits_grow_by_machine_and_are_forgotten_after_ten_minutes() -> None:
    now = [0.0]
    waits = GuessWaits(lambda: now[0])

    grown = [waits.count("a") for _ in range(12)]

    assert grown == [0.0, 0.0, 0.0, 1.0, 2.0, 4.0, 8.0, 16.0, 30.0, 30.0, 30.0, 30.0]
    assert max(waits.count("a") for _ in range(3000)) == MAX_WAIT_S
    assert waits.count("b") == 0.0
    now[0] += FORGET_AFTER_S - 1.0
    assert waits.count("a") == MAX_WAIT_S
    now[0] += FORGET_AFTER_S
    assert waits.count("a") == 0.0


def test_machines_beyond_a_thousand_are_forgotten_the_oldest_first() -> None:
    waits = GuessWaits(lambda: 0.0)
    for _ in range(9):
        waits.count("first")
    for number in range(MAX_MACHINES - 1):
        waits.count(str(number))
    assert waits.count("first") == MAX_WAIT_S
    for number in range(MAX_MACHINES):
        waits.count(str(number))
    assert waits.count("first") == 0.0


# Channels


def test_a_reader_gets_words_and_a_program_sentences(helm: Post) -> None:
    helm.offer(0)

    helm.type("subscribe gauges")

    answer, shown, *_ = helm.said()
    assert answer == "gauges: every tick"
    assert shown.startswith("gauges, 0 s: depth 60.0 m, heading 0.0 deg")


def test_a_channel_that_is_not_the_roles_is_refused_and_logged(helm: Post) -> None:
    answer = helm.answer_to("subscribe motion")

    assert answer.startswith(
        "? motion is not shown here: you have the helm; you may see teletype, gauges"
    )
    assert helm.log[0][0] == "refused"


def test_a_channel_that_there_is_not_is_answered_with_the_nearest(helm: Post) -> None:
    assert helm.answer_to("subscribe stearing") == "? no channel stearing; nearest is steering"
    assert "there is teletype, gauges" in helm.answer_to("subscribe xyz")


def test_subscribing_again_changes_the_rate_and_sends_nothing_twice(helm: Post) -> None:
    helm.offer(0)
    helm.type("subscribe time", "subscribe time at 1 hz")
    helm.said()

    for tick in range(1, 21):
        helm.now += 0.1
        helm.offer(tick)

    assert 2 <= len(helm.said()) <= 3


@pytest.mark.parametrize(("wished", "told"), [("", 10), (" at 50 hz", 10), (" at 2 hz", 2)])
def test_the_view_of_the_periscope_comes_no_faster_than_a_page_shows_it(
    post: MakePost, wished: str, told: int
) -> None:
    scope = post("scope")
    scope.type(order_sentence(f"subscribe scope{wished}", "9"))
    assert f"scope: at most {told} a second" in scope.said()[0]
    scope.offer(0)
    scope.said()

    for tick in range(1, 101):
        scope.now += 0.01
        scope.offer(tick)

    assert told <= len(scope.said()) <= told + 1


def test_unsubscribed_a_channel_comes_no_more(helm: Post) -> None:
    helm.type("subscribe gauges", "subscribe engine")

    assert helm.answer_to("unsubscribe gauges") == "no more gauges"
    helm.offer(1)
    assert all(line.startswith(("engine", "  ")) for line in helm.said())
    assert helm.answer_to("unsubscribe gauges") == (
        "? gauges is not subscribed here; there is engine, events"
    )
    assert helm.answer_to("unsubscribe all") == "no more engine, events"
    helm.offer(2)
    helm.station.tell(News(2, 1.0, "time", "frozen"))
    assert not helm.said()


def test_a_line_for_people_begins_with_the_teletype(helm: Post) -> None:
    helm.station.type_out()

    helm.offer(1)
    helm.offer(2)

    assert [line[:8] for line in helm.said()] == ["time    ", "00:00:00", "00:00:01"]


def test_with_a_role_a_line_keeps_the_channels_that_are_the_roles(line: Post, boat: Boat) -> None:
    line.station.type_out()
    line.type("subscribe tanks", "subscribe steering")

    line.type("role helm")

    assert line.station.wishes.channels == ("teletype", "steering", "events")
    assert boat.state.z == 60.0


def test_an_observer_that_turns_out_to_be_the_instructor_is_shown_the_truth(
    line: Post, boat: Boat
) -> None:
    line.station.type_out()
    crippled = boat.records.state.copy()
    crippled["casualty"][0][0], crippled["casualty_amount"][0][0] = code("depth-gauge-stuck"), 33.0
    line.sending.offer(1, crippled.tobytes(), Pace())
    assert " 33.0>" in line.said()[-1]

    line.type("role instructor")

    assert " 60.0>" in line.said()[-1]


def code(kind: str) -> int:
    from trainer.core.casualties import CODES  # noqa: PLC0415

    return CODES[kind]


# Events


def test_a_program_gets_events_as_sentences(helm: Post) -> None:
    helm.type(order_sentence("subscribe events", "1"))
    helm.said()

    helm.station.tell(News(4, 2.0, "time", "frozen"))

    (line,) = helm.said()
    found = parse_sentence(line)
    assert found
    assert found.fields == ("4", "2.000", "time", "frozen")


# The page


def page() -> str:
    return (ROOT / "docs" / "stations.md").read_text(encoding="utf-8")


def test_every_sentence_on_the_page_has_its_checksum_and_is_one() -> None:
    lines = re.findall(r"^\$TR.*$", page(), re.MULTILINE)

    assert len(lines) > 10
    for line in lines:
        found = parse_line(line) if line.startswith("$TRO") else parse_sentence(line)
        assert found, line
        assert not isinstance(found, Message) or isinstance(found.order, Order), line


def test_the_client_on_the_page_takes_the_helm_and_shows_the_rudder(boat: Boat) -> None:
    (client,) = re.findall(r"```python\n(.*?)```", page(), re.DOTALL)
    wake, shown = threading.Event(), []
    hub = Server(wake)
    port = hub.listen("127.0.0.1", 0)
    names = {"print": lambda *values: shown.append(values)}
    source = client.replace("17800", str(port))
    program = threading.Thread(target=exec, args=(source, names), daemon=True)
    program.start()

    obeyed = tend(hub, wake, boat, program)

    assert [order.text for order in obeyed] == ["rudder left 10"]
    seconds, steering = shown[0]
    assert float(seconds) >= 0.0
    assert steering["rudder_mode"] in {"hand", "auto"}
    assert next(iter(steering)) == "heading"


def tend(hub: Server, wake: threading.Event, boat: Boat, program: threading.Thread) -> list[Order]:
    """Be a session until its client has given an order and gone; return its orders."""
    sending = prompt_sender(boat)
    sending.offer(0, boat.records.state.tobytes(), Pace())
    obeyed: list[Order] = []
    stations: list[Station] = []
    while not obeyed:
        assert wake.wait(60.0)
        wake.clear()
        stations += [Station(line, Access(), sending, print) for line in hub.newcomers()]
        for asked in [asked for station in stations for asked in station.take(MANY)]:
            asked.station.answer(asked, "done")
            obeyed.append(asked.order)
    for station in stations:
        station.close(1.0)
    hub.close(1.0)
    program.join(60.0)
    assert not program.is_alive()
    return obeyed


@pytest.mark.parametrize(
    "line", [f"helm {TOKEN}", f"subscribe {TOKEN.lower()}", f"rudder left {TOKEN}", f"x {TOKEN}y"]
)
def test_a_token_is_not_logged_wherever_it_stands(post: MakePost, line: str) -> None:
    stranger = post(None, TOKEN)
    stranger.type(line, f"role helm {TOKEN}", line)

    assert "***" in stranger.log[0][1]
    assert TOKEN.casefold() not in str(stranger.log).casefold()


# How often


def test_orders_beyond_twenty_a_second_wait_and_that_is_told_once(post: MakePost) -> None:
    helm = post()
    helm.type("role helm")
    helm.line.waiting += ["rudder left 5"] * 500
    taken = 0
    for second in range(11):
        helm.now = float(second)
        while asked := list(helm.station.take(MANY)):
            taken += len(asked)
        assert taken <= ORDERS_AT_ONCE + second * ORDERS_A_SECOND
        assert 0.0 < helm.station.allowance.held_up <= 1.0 / ORDERS_A_SECOND
    assert taken == ORDERS_AT_ONCE + 10 * ORDERS_A_SECOND
    assert len(helm.line.waiting) == 500 - taken  # they wait, and none is lost
    told = [kind for kind, text in helm.log if "orders a second wait" in text]
    assert told == ["refused"]


def test_lines_that_are_no_orders_and_lines_of_the_user_s_own_are_not_held_up(
    post: MakePost,
) -> None:
    noisy = post()
    noisy.type("role helm", *["nonsense"] * 300)
    for _ in range(300):
        assert not noisy.type()
    assert noisy.line.waiting == []
    assert not noisy.station.allowance.held_up
    panel = post("helm")
    taken = panel.type(*["rudder left 5"] * 300)
    for _ in range(300):
        taken += panel.type()
    assert len(taken) == 300
    assert not panel.station.allowance.held_up
