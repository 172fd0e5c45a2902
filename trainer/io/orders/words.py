"""The order words: who obeys each, who may give it, what it works, and when.

``table`` has the wordings of orders, this page what each is. All that a room has to know of an
order word follows from its row, so no other module lists order words. ``help`` shows the topics in
this order.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from functools import partial
from typing import Final

from trainer.io.orders.table import FORMS_BY_WORD, WORD_SETS

# who works the boat
CREW_ROLES: Final = ("helm", "planes", "pilot", "ballast", "diving", "deck", "scope")
TRAINEE: Final = "trainee"  # who trains alone: all of the crew in one, and time
CLASS_LINE: Final = "class"  # which tells each boat where the others are
STRANGER: Final = "stranger"  # who has not said who it is
HAND_AXES: Final = tuple(WORD_SETS["AXIS"].split("|"))  # what a crew may have to work by hand


class Obeyer(Enum):
    """Who obeys an order. The value is the name in the documents."""

    LINE = "the line"
    BOAT = "the boat"
    CREW = "the crew"
    PLANS = "the plans"
    TIME = "time"
    PAST = "the past"
    RECORD = "the record"
    EXERCISE = "the exercise"
    AIDS = "the aids"
    COMMAND = "command"
    CHAIR = "the chair"
    QUESTION = "a question"


JOURNALLED_OBEYERS: Final = (*(Obeyer.BOAT, Obeyer.CREW, Obeyer.PLANS, Obeyer.AIDS, Obeyer.CHAIR),)


@dataclass(frozen=True)
class RoleControl:
    """One permission: its words, and who has it beside the instructor.

    The words end in the verb, as in "the rudder is", so that a refusal can name whose it is.
    Without words the refusal names the order.
    """

    says: str = ""
    roles: tuple[str, ...] = ()


@dataclass(frozen=True)
class OrderWord:
    """One order word.

    ``works`` are the hand axes that the order works by hand, ``gives_up`` those that it gives to
    the autopilot. If ``works_by`` or ``gives_up_by`` is not empty, it does so with that word alone,
    as in `rudder auto`. A test holds them to what the order writes.
    """

    name: str
    obeyer: Obeyer
    control: RoleControl = RoleControl()
    works: tuple[str, ...] = ()
    works_by: str = ""
    gives_up: tuple[str, ...] = ()
    gives_up_by: str = ""
    needs: str = ""  # the table that a vessel file must have
    in_state: bool = False  # what is ordered stands in the boat's state
    scheduled: bool = False  # a file of orders may hold it
    planned: bool = False  # an instructor may give it for later
    watching: bool = False  # an instructor without command may give it
    in_replay: bool = True
    after_end: bool = True  # of the exercise
    jumps: bool = False  # to another moment, where a new branch begins
    anew: bool = False  # the jump undoes even what happened at the tick gone back to
    paced: bool = False  # a trainee may give it between two runs of a course, at his own pace
    in_page: bool = False  # a boat in a page obeys it, beside orders that only write numbers
    looks: bool = False  # a page sends it that only looks at a boat, beside its role

    @property
    def journalled(self) -> bool:
        """Return whether the order is written into the journal before it acts."""
        return self.obeyer in JOURNALLED_OBEYERS

    @property
    def passed_on(self) -> bool:
        """Return whether others hear the order with its answer. The rest send news of their own."""
        return self.journalled or self.obeyer in (Obeyer.TIME, Obeyer.PAST, Obeyer.RECORD)

    @property
    def automatic_order(self) -> str:
        """Return the order that gives up axes, as exercises allow it: `course`, `rudder auto`."""
        return f"{self.name} {self.gives_up_by}".rstrip()

    @property
    def has_sides(self) -> bool:
        """Return whether it moves something to a side: left or right, dive or rise."""
        patterns = " ".join(form.pattern for form in FORMS_BY_WORD[self.name])
        return not {"SIDE", "TILT"}.isdisjoint(patterns.split())

    def needs_autopilot(self, word: str) -> bool:
        """Return whether the order with that word is for boats with an autopilot alone."""
        return self.needs == "autopilot" or (bool(word) and word == self.gives_up_by)

    def takes(self, word: str) -> tuple[str, ...]:
        """Return the hand axes that the order with that word works, or says to have."""
        if self.name == "have":
            return (word,)
        return tuple(dict.fromkeys((*self.moves(word), *self.automates(word))))

    def moves(self, word: str) -> tuple[str, ...]:
        """Return the hand axes that the order with that word works by hand."""
        return self.works if word == self.works_by or not self.works_by else ()

    def automates(self, word: str) -> tuple[str, ...]:
        """Return the hand axes that the order with that word gives to the autopilot."""
        gives_up = word == self.gives_up_by if self.gives_up_by else word != "off"
        return self.gives_up if gives_up else ()


@dataclass(frozen=True)
class Topic:
    """One line of an overview: how to type its orders, what they do, and these."""

    example: str
    says: str
    words: tuple[OrderWord, ...]


HELM_ROLES: Final = ("helm", "pilot")
PLANES_ROLES: Final = ("planes", "pilot", "diving")
BALLAST_ROLES: Final = ("ballast", "diving")
RUDDER_CONTROL: Final = RoleControl("the rudder is", HELM_ROLES)
COURSE_CONTROL: Final = RoleControl("the course is", HELM_ROLES)
ENGINE_CONTROL: Final = RoleControl("the engine is", HELM_ROLES)
PLANES_CONTROL: Final = RoleControl("the planes are", PLANES_ROLES)
LEVER_CONTROL: Final = RoleControl("the lever is", ("visitor",))
DEPTH_CONTROL: Final = RoleControl("the depth is", PLANES_ROLES)
MAIN_BALLAST_CONTROL: Final = RoleControl("main ballast is", BALLAST_ROLES)
NEGATIVE_TANK_CONTROL: Final = RoleControl("the negative tank is", BALLAST_ROLES)
TRIM_WATER_CONTROL: Final = RoleControl("trim water is", BALLAST_ROLES)
HOVERING_CONTROL: Final = RoleControl("hovering is", BALLAST_ROLES)
COMPRESSOR_CONTROL: Final = RoleControl("the compressor is", BALLAST_ROLES)
BOTH_WAYS_CONTROL: Final = RoleControl("surfacing and diving are", ("diving",))
RUDDER_MODE_CONTROL: Final = RoleControl("the rudder's mode is", (*HELM_ROLES, "diving"))
PLANES_MODE_CONTROL: Final = RoleControl("the planes' mode is", PLANES_ROLES)
PLANT_CONTROL: Final = RoleControl("the plant is", BALLAST_ROLES)
CREW_ORDERS_CONTROL: Final = RoleControl("orders to the crew are", ("diving", "deck"))
CREW_WORDS_CONTROL: Final = RoleControl("orders in words are", ("diving",))
SAYINGS_CONTROL: Final = RoleControl("reports and repeats are", CREW_ROLES)
PERISCOPE_CONTROL: Final = RoleControl("the periscope is", ("scope",))
REMARKS_CONTROL: Final = RoleControl("the record is", ("observer", "scope"))
READINESS_CONTROL: Final = RoleControl("to be ready is", CREW_ROLES)
WATCH_CONTROL: Final = RoleControl("the watch is", CREW_ROLES)
HANDS_CONTROL: Final = RoleControl(
    "what is worked by hand is", ("helm", "planes", "pilot", "ballast", "diving")
)
FIRST_DIVE_CONTROL: Final = RoleControl("the dive from the start is", ("visitor",))
AUTOPILOT_CONTROL: Final = RoleControl("the autopilot as a whole is", (TRAINEE,))
TRAINEE_CONTROL: Final = RoleControl("", (TRAINEE,))
COMMON_CONTROL: Final = RoleControl("", (*CREW_ROLES, "observer", "visitor", TRAINEE))
STRANGER_CONTROL: Final = RoleControl("", (*COMMON_CONTROL.roles, STRANGER))

# Rows of one obeyer have most in common.
# fmt: off
boat_order = partial(
    OrderWord, obeyer=Obeyer.BOAT, in_state=True, scheduled=True, planned=True, in_replay=False,
    after_end=False)
autopilot_order = partial(boat_order, needs="autopilot")
tank_order = partial(boat_order, needs="ballast")
plant_order = partial(boat_order, needs="plant", control=PLANT_CONTROL)
planes_order = partial(
    boat_order, control=PLANES_CONTROL, works=("planes",), gives_up=("planes",), gives_up_by="auto")
crew_order = partial(OrderWord, obeyer=Obeyer.CREW, in_replay=False)
line_order = partial(OrderWord, obeyer=Obeyer.LINE, control=COMMON_CONTROL, watching=True)
time_order = partial(OrderWord, obeyer=Obeyer.TIME, control=TRAINEE_CONTROL, scheduled=True)
past_order = partial(OrderWord, obeyer=Obeyer.PAST)
exercise_order = partial(OrderWord, obeyer=Obeyer.EXERCISE)
command_order = partial(OrderWord, obeyer=Obeyer.COMMAND)
plan_order = partial(OrderWord, obeyer=Obeyer.PLANS, in_replay=False)
question = partial(OrderWord, obeyer=Obeyer.QUESTION, watching=True)
aid = partial(
    OrderWord, obeyer=Obeyer.AIDS, control=TRAINEE_CONTROL, in_replay=False, after_end=False)

# One line each in an overview, which must fit in 24 lines of 79 columns.
BOAT_TOPICS: Final = (
    # depth needs the autopilot, too, but a depth too deep for the boat is refused before
    Topic("depth 80 | 260 ft | auto", "keep a depth", (
        boat_order("depth", control=DEPTH_CONTROL, gives_up=("planes",)),)),
    Topic("course 090 | left 30 | auto", "keep a course, or change it", (
        autopilot_order("course", control=COURSE_CONTROL, gives_up=("rudder",)),
        autopilot_order("course-by", control=COURSE_CONTROL, gives_up=("rudder",)),
        autopilot_order("course-to", control=COURSE_CONTROL, gives_up=("rudder",)))),
    Topic("speed 12 | 6 m/s | auto", "keep a speed, in knots", (
        autopilot_order("speed", control=ENGINE_CONTROL, gives_up=("speed",)),)),
    Topic("turns 12 | rpm 80", "revolutions, held constant", (
        boat_order("turns", control=ENGINE_CONTROL, works=("speed",)),
        boat_order("rpm", control=ENGINE_CONTROL, works=("speed",)))),
    Topic("bell ahead standard | stop", "engine order; also `full astern`", (
        boat_order("bell", control=ENGINE_CONTROL, works=("speed",)),)),
    Topic("rudder left 15 | amidships", "also right, full, manual, auto", (
        boat_order("rudder", control=RUDDER_CONTROL, works=("rudder",), gives_up=("rudder",),
                   gives_up_by="auto"),)),
    Topic("stern planes dive 10 | bow rise 10", "also zero, manual, auto", (
        planes_order("stern"), planes_order("bow"))),
    Topic("planes zero | auto | lever dive 8", "both pairs of planes at once", (
        planes_order("planes"),
        boat_order("lever", control=LEVER_CONTROL, works=("planes",)))),
    Topic("autopilot on | off | report", "switch it, or choose its law", (
        autopilot_order("autopilot", control=AUTOPILOT_CONTROL, works=HAND_AXES, works_by="off",
                        gives_up=HAND_AXES, gives_up_by="on"),)),
    Topic("surface | dive | periscope depth", "come up; flood; scope raise", (
        tank_order("surface", control=BOTH_WAYS_CONTROL),
        tank_order("dive", control=BOTH_WAYS_CONTROL),
        boat_order("periscope", control=DEPTH_CONTROL, gives_up=("planes",)),
        boat_order("scope", control=PERISCOPE_CONTROL))),
    Topic("blow all | stop | emergency blow", "main ballast; also mid, aft", (
        tank_order("blow", control=MAIN_BALLAST_CONTROL),
        tank_order("emergency", control=MAIN_BALLAST_CONTROL))),
    Topic("vent all open | negative flood", "air out; the negative tank", (
        tank_order("vent", control=MAIN_BALLAST_CONTROL),
        tank_order("negative", control=NEGATIVE_TANK_CONTROL, works=("ballast",)))),
    Topic("flood auxiliary 5 | pump | trim auto", "tonnes to be moved; drain", (
        tank_order("flood", control=TRIM_WATER_CONTROL, works=("ballast",)),
        tank_order("pump", control=TRIM_WATER_CONTROL, works=("ballast",)),
        autopilot_order("trim", control=TRIM_WATER_CONTROL, works=("ballast",),
                        gives_up=("ballast",), gives_up_by="auto"),
        tank_order("drain", control=TRIM_WATER_CONTROL, works=("ballast",)))),
    Topic("hover on | compressor on", "keep depth stopped; charge air", (
        tank_order("hover", control=HOVERING_CONTROL, works=("ballast",), gives_up=("ballast",)),
        tank_order("compressor", control=COMPRESSOR_CONTROL, works=("ballast",)))),
    Topic("stern emergency | isolate main", "what feeds it; breaker, bus, fight", (
        plant_order("rudder-mode", control=RUDDER_MODE_CONTROL, works=("rudder",)),
        plant_order("planes-mode", control=PLANES_MODE_CONTROL, works=("planes",)),
        plant_order("isolate"),
        plant_order("open"),
        plant_order("hydraulic"),
        plant_order("bus"),
        plant_order("breaker"),
        plant_order("loads"),
        plant_order("ventilation"),
        plant_order("fight"))),
    Topic("sea state 5 | current off", "also wind 30, calm; set 090 drift 2", (
        boat_order("sea", in_page=True), boat_order("current"))),
    Topic("casualty NAME | clear all", "also NAME 0.5 ramp 30; contact TUG ...", (
        boat_order("casualty", in_page=True),
        boat_order("clear", in_page=True),
        question("casualties", in_page=True),
        boat_order("contact"))),
    Topic("freeze | run | step 10", "stop time, let it go on, 10 ticks", (
        time_order("freeze", planned=True, in_page=True),
        time_order("run", after_end=False, paced=True, in_page=True),
        time_order("step", after_end=False, in_page=True))),
    Topic("status", "everything about the boat, once", (
        question("status", control=COMMON_CONTROL, in_page=True),)),
    Topic("help rudder", "all about one order", (line_order("help", control=STRANGER_CONTROL),)),
    Topic("quit", "end the session", (time_order("quit"),)),
)
SESSION_TOPICS: Final = (
    Topic("time x2 | max", "speed of time", (time_order("time", in_page=True),)),
    Topic("freeze depth | release all", "hold depth, position or tanks", (
        boat_order("hold"), boat_order("release"))),
    Topic("snapshot before-jam | snapshots", "keep a moment; list them", (
        OrderWord("snapshot", Obeyer.RECORD, scheduled=True, in_page=True),
        question("snapshots", in_page=True))),
    Topic("restore before-jam | reset", "back to it, or to the start", (
        past_order("restore", scheduled=True, jumps=True, in_page=True),
        past_order("reset", scheduled=True, jumps=True, anew=True, in_page=True))),
    Topic("backtrack 2 min", "back by so much, and on from there", (
        past_order("backtrack", control=TRAINEE_CONTROL, scheduled=True, jumps=True,
                   in_page=True),)),
    Topic("replay 90 s | take over", "watch it again; go on from here", (
        past_order("replay", scheduled=True, in_page=True),
        past_order("take", scheduled=True, in_page=True))),
    Topic("branches | branch 1", "what was left behind; back to its end", (
        question("branches", in_page=True),
        past_order("branch", jumps=True, in_page=True))),
    Topic("end exercise | release marks | debrief", "and what came of it", (
        exercise_order("end", control=TRAINEE_CONTROL, in_replay=False, after_end=False),
        exercise_order("release-marks"),
        exercise_order("debrief", control=TRAINEE_CONTROL))),
    Topic("again | again from here | next", "once more; others", (
        past_order("again", control=TRAINEE_CONTROL, jumps=True, anew=True, paced=True),
        past_order("restart", control=FIRST_DIVE_CONTROL, jumps=True, anew=True),
        exercise_order("next", control=TRAINEE_CONTROL, paced=True))),
    Topic("demonstrate | hint | ghost on", "the way shown; help that costs marks", (
        exercise_order("demonstrate", control=TRAINEE_CONTROL, after_end=False),
        exercise_order("hint", control=TRAINEE_CONTROL, in_replay=False, after_end=False),
        aid("ghost"),
        aid("predictor"))),
    Topic("take command | give | keep command", "of several instructors", (
        command_order("command", watching=True), command_order("give", looks=True),
        command_order("keep"))),
    Topic("role helm | role helm TOKEN | ready", "what a line may do; it is ready", (
        OrderWord("role", Obeyer.CHAIR, STRANGER_CONTROL, watching=True, in_replay=False),
        exercise_order("ready", control=READINESS_CONTROL))),
    Topic("in 30 s depth 80 | plans | cancel 1", "also at 2 min, when depth > 60 then", (
        plan_order("plan", after_end=False), question("plans"), plan_order("cancel"))),
    Topic("order course 045 | belay | allow planes", "to the crew", (
        crew_order("order", control=CREW_ORDERS_CONTROL, in_state=True, scheduled=True,
                   planned=True, after_end=False),
        crew_order("belay", control=CREW_ORDERS_CONTROL),
        crew_order("allow"))),
    Topic("tell ready | report ready | aye", "to and from the crew; have planes", (
        crew_order("tell", control=CREW_WORDS_CONTROL, scheduled=True, planned=True),
        crew_order("report", control=SAYINGS_CONTROL, scheduled=True),
        crew_order("aye", control=SAYINGS_CONTROL),
        crew_order("have", control=HANDS_CONTROL))),
    Topic("mark good recovery | what if blow all", "a remark; marks with it", (
        question("mark", control=REMARKS_CONTROL, in_page=True),
        question("what-if", in_replay=False, after_end=False))),
    Topic("log 20 | alerts | ack 3", "what has happened; alerts seen", (
        question("log", control=COMMON_CONTROL, in_page=True),
        question("alerts", control=COMMON_CONTROL),
        question("ack", control=COMMON_CONTROL))),
    Topic("briefing", "what the exercise is about", (
        question("briefing", control=COMMON_CONTROL),)),
    Topic("who | name wall | relief Berg", "stations; one called; who has the watch", (
        question("who", control=COMMON_CONTROL), line_order("name", looks=True),
        crew_order("relief", control=WATCH_CONTROL))),
    Topic("subscribe diving at 2 hz", "have a channel sent, or not", (
        line_order("subscribe", looks=True), line_order("unsubscribe"))),
    Topic("history diving 60 min", "what a channel has shown so far", (
        question("history", control=COMMON_CONTROL, in_page=True, looks=True),)),
    Topic("detach", "leave; the session goes on", (
        line_order("detach", control=STRANGER_CONTROL),)),
)
# fmt: on
ORDER_WORDS: Final[Mapping[str, OrderWord]] = {
    word.name: word for topic in BOAT_TOPICS + SESSION_TOPICS for word in topic.words
}
BOAT_ORDERS: Final = frozenset(name for name, word in ORDER_WORDS.items() if word.in_state)
# What is said between those who order the crew, the crew and the instructor: journalled as well.
CREW_TALK: Final = frozenset(
    name for name, word in ORDER_WORDS.items() if word.obeyer is Obeyer.CREW
)
# Orders after which nothing of their moment stands.
ANEW_ORDERS: Final = tuple(name for name, word in ORDER_WORDS.items() if word.anew)
# The orders that hand over to the autopilot what a crew works by hand.
AUTOMATIC_ORDERS_BY_AXIS: Final[Mapping[str, tuple[str, ...]]] = {
    axis: tuple(word.automatic_order for word in ORDER_WORDS.values() if axis in word.gives_up)
    for axis in HAND_AXES
}
