"""What stations say in scripts, and which exercises they play."""

from collections.abc import Mapping
from typing import Final

from simulation.disk import Trouble
from simulation.script import Mishap

EXERCISES: Final = (
    *("", "", "depth-changes", "visitor-dive", "rise-jam-shallow", "watch"),
    *("crossing-traffic", "bottoming", "periscope-depth"),
)  # "": none
# What is there more than once is said more often.
WORDS: Final[Mapping[str, str]] = {
    "instructor": """freeze|run|run|run|step 3|step 40|time 20|time 1|time 100|snapshot A|snapshot B
        |restore A|restore B|reset|backtrack 5 s|backtrack 30 s|replay 10 s|replay 20 s|take over
        |again|again from here|again from A|again from 20 s|branch 1|branch 2|branch 9
        |branches|branches|branches|snapshots|snapshots|snapshots|plans
        |at 30 s depth 70|in 10 s depth 80|in 2 s course 010|at 1 s emergency blow
        |when depth over 62 then rudder left 5|cancel 1|cancel all|end exercise|release marks
        |debrief|take command|give command|keep command|mark hello|casualty rudder-stuck
        |casualty stern-slow 0.5 ramp 20|clear all|casualties|clear rudder-stuck
        |sea state 4|sea state 0|order depth 90|order course 120
        |tell helm steady|depth 70|course 090|rudder left 10|history motion 20 s|who|status|log 5
        |quit|current set 090 drift 2|current off|ack 1|ack silent 1|restart|emergency blow
        |subscribe motion|subscribe ledger|unsubscribe all|alerts|allow planes|allow ballast
        |autopilot on|autopilot off|belay|briefing|course left 30|come right to 090|demonstrate
        |ghost on|ghost off|predictor 60 s|hint|freeze depth|release depth|release all|next
        |what if depth 80|dive|surface|drain aft|drain stop|pump trim forward 2|pump auxiliary 1
        |periscope depth|rpm 60|turns 4|name wall|detach|casualty oil-leak-header|loads shed
        |casualty bus-port-lost|casualty fire-aft|bus tie shut|stern emergency|isolate main
        |ack 2|ack all|ack silent 2|casualty grounding-aft|clear grounding-aft
        |casualty flooding-aft 2 ramp 60|clear flooding-aft""",
    "helm": """rudder left 10|rudder right 20|rudder midships|course 045|speed 8|bell ahead full|aye
        |report ready|ready|status|depth 70|freeze|who|subscribe steering|history gauges 20 s
        |rudder manual|rudder auto|mark late|course right 20|come left to 300|turns 5|rpm 80
        |alerts|ack 1|have rudder|relief Berg|rudder emergency|rudder normal|rudder hand""",
    "planes": """stern rise 5|stern dive 10|bow dive 3|planes zero|depth 80|aye|report ready|ready
        |planes manual|planes auto|rudder left 5|log 3|subscribe diving|mark|periscope depth
        |ack all|ack 1|ack silent 1|have planes|relief Ott|planes emergency|stern normal
        |bow hand|subscribe supply""",
    "ballast": """blow forward|blow aft|vent forward open|vent aft open|vent forward shut
        |negative flood|trim auto|trim manual|emergency blow|compressor on|hover on|hover off
        |flood auxiliary 5|pump auxiliary 3|pump trim aft 2|drain forward|ready|report ready|aye
        |name tanks|unsubscribe all|isolate main|isolate stern|open main|open stern|loads shed
        |hydraulic pump 2 run|hydraulic pump vital stop|bus tie shut|bus tie open|loads back
        |breaker port open|breaker port shut|ventilation secure|ventilation run|fight fire aft
        |subscribe plant|ack 1|ack 2|ack 3|ack silent 1""",
    "observer": "mark one|mark two|who|status|log 9|subscribe gauges|history events 60 s|help",
    "visitor": "lever dive 3|lever rise 2|lever zero|restart|status|freeze|mark no",
    "trainee": "depth 70|course 045|freeze|run|autopilot on|status|ready|hint",
}
CHOICES: Final = {
    role: tuple(each.strip() for each in words.split("|")) for role, words in WORDS.items()
}
# What an instructor says in a row: each leads to where single words seldom come.
SCENES: Final = (
    "snapshot A|casualty stern-slow 0.5 ramp 20|restore A",
    "casualty rudder-stuck|snapshot B|clear all|restore B",
    "casualty rudder-slow 0.7 ramp 30|snapshot A|backtrack 1 s|restore A",
    "replay 10 s|freeze|take over",
    "time 1|replay 20 s|take over|mark taken over",
    "run|time 1|run|replay 60 s",
    "replay 10 s|mark seen again|snapshot B|restore B",
    "replay 20 s|replay 5 s|backtrack 2 s",
    "in 3 s depth 80|snapshot A|cancel all|restore A",
    "freeze|in 0 s depth 70|snapshot A|restore A|run",
    "time 1|run|replay 60 s|who|status|take over|take over|take over",
    "run|mark here|restore A|mark again|branch 1",
    "snapshot A|in 10 s depth 90|restore A|run",
    "at 20 s depth 70|freeze|backtrack 5 s|run",
    "run|at 1 s emergency blow|at 1 s depth 70",
    "at 1 s emergency blow|at 1 s casualty rudder-stuck",
    "snapshot A|end exercise|restore A|run",
    "end exercise|again|run",
    "debrief|debrief|again",
    "end exercise|release marks|next",
    "ghost on|hint|what if depth 80",
    "ghost on|predictor 30 s|backtrack 2 s|ghost off",
    "demonstrate for 10 s|freeze|run",
    "take command|run|give command",
    "order depth 90|tell helm steady|belay|backtrack 1 s",
    "planes manual|stern dive 20|bell ahead full|run|time 100",
    "surface|time 100|run",
    "sea state 5|current set 090 drift 2|snapshot A|current off|restore A",
    "freeze depth|backtrack 1 s|release all",
    "branch 1|branch 2|mark here|branch 1",
    "casualty bus-port-lost|step 4|ack all|backtrack 1 s|run",
    "casualty bus-port-lost|step 4|snapshot A|ack all|step 4|restore A|branch 1",
    "casualty bus-starboard-lost|step 4|ack silent 1|ack silent 2|restore A|run",
    "casualty grounding-aft|step 4|snapshot B|clear grounding-aft|step 60|restore B|run",
    "casualty rudder-slow|casualty stern-slow|step 2|clear rudder-slow|step 4|backtrack 1 s",
    "in 2 s casualty rudder-stuck|step 8|clear all|step 4|run",
)
TAKE_OVER_ROW: Final = "time 1|step 40|replay 15 s|who|who|who|who|who|take over|take over"
# What each instructor says first, dealt by seed, so that none is missed. Who comes second says the
# next row: so one asks for command, and the other keeps it.
DEALT: Final = (
    *(2 * ("run|take command|keep command|take command|keep command|take command|keep command",)),
    "ghost on|run|what if depth 80|freeze|what if depth 80|predictor 60 s|run",
    "who|casualties|quit|quit",
    "order depth 90|belay|flood auxiliary 5|freeze|allow planes|demonstrate for 5 s|who|run",
    "end exercise|release marks|run|again",
    "casualty oil-leak-header|step 200|rudder emergency|planes emergency|isolate main|open main",
    (
        "casualty bus-port-lost|bus tie shut|compressor on|step 20|loads shed|breaker port open|"
        "loads back"
    ),
    (
        "casualty cells-lost 0.7|step 40|casualty cells-lost 0.9|step 40|casualty fire-aft|"
        "step 120|ventilation secure|fight fire aft|hydraulic pump 1 stop"
    ),
    (
        "run|casualty oil-leak-stern|step 40|snapshot A|isolate stern|stern hand|restore A|run|"
        "replay 5 s|take over|replay 5 s|freeze|take over"
    ),
    "run|casualty bus-starboard-lost|snapshot B|bus tie shut|backtrack 2 s|restore B|run",
    "run|planes manual|stern dive 20|step 900|run|run|run|mark crushed|backtrack 20 s",
    "role helm|who|role instructor|scope raise",
    "run|breaker starboard open|breaker port open|mark dark|reset|ventilation exhaust",
    "step 4|at 1 s depth 70|in 9000 s depth 80|when depth over 400 then rudder left 5|run",
    "freeze|in 90 s depth 80|in 95 s course 010|cancel all|in 2 s depth 75|step 8|run",
    "run|who|who|backtrack 1 s|step 140|who|run",
    TAKE_OVER_ROW,
)
# What befalls the disk while such a row is said: from when on, and for how long [s].
TROUBLED: Final = {TAKE_OVER_ROW: Mishap(0.7, Trouble.UNREADABLE, 2.0)}
# What few may say: each of the others first says some of it, dealt likewise.
FOREIGN: Final = (
    *("scope raise", "negative flood", "hover on", "compressor on", "surface", "isolate main"),
    *("lever dive 3", "emergency blow", "drain aft", "rudder emergency", "stern emergency"),
    *("report ready", "ready", "have planes", "relief Berg", "order depth 90", "tell look out"),
    *("restart", "mark mine", "rudder left 5", "planes zero", "depth 60", "course 020", "turns 5"),
    *("vent aft shut", "autopilot on"),
)
NOISE: Final = (
    *("\xff\xfd\x01hel\xff\r\n", "$TRO,900001,depth 70*00\r\n", "nonsense\r\n", "\r\n\n\r"),
    *("x" * 3000 + "\r\n", "depth 99999\r\n", "\x1b[2J\r\n", "caf\xe9\r\n", "$$$***\r\n"),
    *("depth 7\b80\r\n", "name \u20ac\r\n".encode().decode("latin-1")),
)
