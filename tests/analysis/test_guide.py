"""The qualification test guide: verdicts, findings, published results, baseline and document."""

import json
import re
import subprocess
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

from trainer.analysis.guide import page as guide_page
from trainer.analysis.guide import programme, verdicts
from trainer.analysis.guide.contents import (
    GuideContents,
    assemble_guide,
    compare_guides,
    load_earlier,
    write_guide,
)
from trainer.analysis.guide.page import render
from trainer.analysis.guide.programme import (
    Task,
    fly_all,
    guide_legs,
    legs_of_1969,
    legs_of_trainer,
)
from trainer.analysis.guide.verdicts import (
    BEYOND_TOLERANCE,
    NOT_JUDGED,
    WITHIN_TOLERANCE,
    judge_measure,
)
from trainer.analysis.manoeuvres.catalogue import find_manoeuvre
from trainer.analysis.manoeuvres.flight import Flight
from trainer.analysis.manoeuvres.turns import Turn
from trainer.analysis.manoeuvres.vehicle import Measure, share_measure
from trainer.analysis.reduce.objective import Candidate, Yardstick
from trainer.analysis.reduce.reduction import as_filed
from trainer.boat.assemble import Method
from trainer.cli.workshop.guide import guide, manoeuvre
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError
from trainer.config.ship.series import load_series
from trainer.report.pdf import find_browser
from trainer.units import KNOT

MADE = "2026-01-01 00:00:00 UTC"


@pytest.fixture(scope="module")
def book() -> GuideContents:
    """Return the whole guide of BB2, flown in this process."""
    file = load_vessel("bb2")
    return write_guide(file, guide_legs(file), MADE, 1, lambda: None)


@pytest.fixture(scope="module")
def page(book: GuideContents) -> str:
    return guide_page.html_page(book, None)


# --- verdicts


def test_a_number_within_its_share_passes_and_one_beyond_fails() -> None:
    full = share_measure("advance", "m", 200.0)

    assert judge_measure(full, share_measure("advance", "m", 209.9)).verdict == WITHIN_TOLERANCE
    assert judge_measure(full, share_measure("advance", "m", 189.9)).verdict == BEYOND_TOLERANCE
    assert judge_measure(full, None).verdict == BEYOND_TOLERANCE
    assert judge_measure(share_measure("advance", "m", None), full).verdict == NOT_JUDGED


def test_a_swing_that_a_set_lacks_is_forgiven_if_it_is_small() -> None:
    small, large = (Measure("pitch peak 2", "rad", value, 0.05) for value in (0.04, 0.06))

    assert judge_measure(small, None).verdict == WITHIN_TOLERANCE
    assert judge_measure(large, None).verdict == BEYOND_TOLERANCE


def test_the_same_flight_passes_and_a_flight_by_another_rudder_fails() -> None:
    file = load_vessel("bb2")
    method = Method("full", "exact", "exact", "rk4", 0.5)
    flown = [
        programme.fly_task(file.path, Task(Turn(angle), 10.0 * KNOT, method))
        for angle in (15.0, 18.0)
    ]
    one, other = (flight for flight in flown if isinstance(flight, Flight))

    same = {each.verdict for each in verdicts.judge(Turn(), one, one)}
    different = {each.quantity: each.verdict for each in verdicts.judge(Turn(), one, other)}

    assert same == {WITHIN_TOLERANCE}
    assert different["steady diameter"] == BEYOND_TOLERANCE
    assert different["change of psi, 120 s"] == BEYOND_TOLERANCE


# --- flights on several processors


@pytest.mark.process
def test_several_processors_fly_to_the_same_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    file = load_vessel("bb2")
    method = Method("modified", "lagged", "exact", "adams2", 0.5)
    wanted = [Task(find_manoeuvre("meander"), knots * KNOT, method) for knots in (6.0, 8.0, 10.0)]
    seen: list[None] = []

    alone = fly_all(file.path, wanted, 1, lambda: None)
    monkeypatch.setattr(programme, "LONE_FLIGHTS", 0)
    together = fly_all(file.path, wanted, 2, lambda: seen.append(None))

    assert len(seen) == len(wanted)
    for task in wanted:
        one, other = alone[task], together[task]
        assert isinstance(one, Flight)
        assert isinstance(other, Flight)
        for name in one.series.columns:
            assert np.array_equal(one.column(name), other.column(name)), name


# --- BB2's own guide


def test_every_manoeuvre_is_flown_both_ways_deep_and_some_near_the_surface() -> None:
    found = guide_legs(load_vessel("bb2"))
    titles = [leg.title for leg in found]

    for way, other in (("starboard", "port"), ("rise", "dive")):
        ones = [title for title in titles if way in title]
        assert len(ones) > 12
        turned = [title.replace(way, other) for title in ones if "climbing" not in title]
        assert set(turned) <= set(titles)
    assert {leg.rig.depth for leg in found if not leg.manoeuvre.in_waves} == {None, 24.0}
    assert [leg.title for leg in found if leg.manoeuvre.in_waves] == [
        "beam-sea, 10 kn, 20.1 m deep"
    ]
    assert {"backing, from rest", "crash-stop, 10 kn"} <= set(titles)
    assert {"plane-jam, rise, 10 kn", "rudder-jam, port, 10 kn"} <= set(titles)
    assert "out-of-balance, +0.2%, planes still, 10 kn" in titles


def test_at_a_depth_every_leg_begins_there_and_what_the_boat_cannot_is_refused() -> None:
    file = load_vessel("bb2")

    assert {leg.rig.depth for leg in guide_legs(file, 60.0)} == {60.0}
    assert len(guide_legs(file, 60.0)) < len(guide_legs(file))
    with pytest.raises(ConfigError, match=r"begin at 11\.2 m or deeper"):
        guide_legs(file, 5.0)
    with pytest.raises(ConfigError, match="below max_depth_m = 250 m"):
        legs_of_1969(file, 900.0)


def test_a_boat_without_a_diameter_does_not_feel_the_surface() -> None:
    legs = guide_legs(load_vessel("sdv-mk9"))
    assert {leg.rig.depth for leg in legs if not leg.manoeuvre.in_waves} == {None}


def test_the_programme_of_1969_has_its_forty_overshoots_and_fifteen_turns() -> None:
    names = [leg.name for leg in legs_of_1969(load_vessel("bb2"))]

    assert names.count("overshoot") == 40
    assert names.count("turn") == 15
    assert {leg.speed_kn for leg in legs_of_1969(load_vessel("bb2")) if leg.name == "turn"} == {
        *(4.0, 8.0, 12.0, 16.0, 20.0)
    }


def test_the_programme_of_a_trainer_is_what_section_v_asks() -> None:
    file = load_vessel("bb2")
    legs = legs_of_trainer(file)

    flights = [(leg.name, leg.speed_kn) for leg in legs]
    # of the report's boat the damping ratio is largest at about 7 kn
    assert flights[:5] == [("meander", speed) for speed in (4.0, 7.5, 12.0, 16.0, 20.0)]
    angles = {(leg.speed_kn, leg.variant) for leg in legs if leg.name in ("overshoot", "turn")}
    assert angles == {
        (speed, variant)
        for speed in (4.0, 20.0)
        for variant in ("execute 5 deg", "execute 20 deg", "rudder 15 deg", "rudder 30 deg")
    }
    assert [leg.title for leg in legs[13:]] == ["utmost-acceleration, from rest"]
    assert 4 * len(legs) < len(legs_of_1969(file))
    assert {leg.rig.depth for leg in legs_of_trainer(file, 60.0)} == {60.0}


def test_a_trainer_s_turn_keeps_its_depth_by_the_stern_planes_alone() -> None:
    file = load_vessel("bb2")
    leg = next(leg for leg in legs_of_trainer(file) if leg.name == "turn")

    flight = programme.fly_task(file.path, leg.task(file, "full"))
    assert isinstance(flight, Flight)
    assert np.ptp(flight.column("delta_b")) == 0.0
    assert np.ptp(flight.column("delta_s")) > np.deg2rad(0.5)


def judgement(quantity: str, verdict: str) -> verdicts.Judgement:
    return verdicts.Judgement(quantity, "rad", 1.0, 1.0, 0.05, verdict)


def test_a_trainer_s_meander_is_judged_by_swings_else_by_the_change_at_two_minutes() -> None:
    swings = (judgement("pitch peak 1", WITHIN_TOLERANCE), judgement("pitch zero 1", "BEYOND"))
    change = judgement("change of theta, 120 s", BEYOND_TOLERANCE)
    other = judgement("largest pitch", BEYOND_TOLERANCE)
    lost = judgement(verdicts.LOST_QUANTITY, BEYOND_TOLERANCE)

    def judged(*found: verdicts.Judgement) -> list[str]:
        kept = verdicts.keep_checks(found, programme.TRAINER_CHECKS["meander"])
        return [one.quantity for one in kept if one.verdict != NOT_JUDGED]

    assert judged(*swings, change, other) == ["pitch peak 1", "pitch zero 1"]
    assert judged(change, other) == ["change of theta, 120 s"]
    assert judged(*swings, lost) == ["pitch peak 1", "pitch zero 1", verdicts.LOST_QUANTITY]


def run_trainer_guide(*arguments: str) -> Result:
    asked = [*arguments, "--programme", "trainer", "--cores", "1"]
    return CliRunner().invoke(guide, asked, catch_exceptions=False)


def test_a_trainer_s_guide_has_page_figures_and_verdict(tmp_path: Path) -> None:
    document = tmp_path / "short.html"
    result = run_trainer_guide("bb2", "--html", str(document), "--json")

    told = json.loads(result.stdout)
    assert result.exit_code == 0
    assert told["passed"]
    assert not told["findings"]
    assert not told["steps"]
    turn = next(sheet for sheet in told["sheets"] if sheet["title"] == "turn, rudder 30 deg, 20 kn")
    judged = [one["quantity"] for one in turn["judgements"]["modified"] if one["allowed"]]
    assert judged == [
        *("heading after 60 s", "steady speed, of the first", "snap roll", "steady roll"),
    ]
    text = document.read_text(encoding="utf-8")
    assert text.count("<section") == len(told["sheets"]) + 2
    assert "meander, 7.5 kn" in text
    assert "Published figures" not in text


@pytest.mark.slow
def test_a_trainer_s_guide_of_a_set_that_is_out_ends_with_exit_code_1(tmp_path: Path) -> None:
    path = tmp_path / "boat.toml"
    path.write_text(without_reduction(load_vessel("bb2").text), encoding="utf-8")

    result = run_trainer_guide(str(path))

    assert result.exit_code == 1
    assert "The compact set beside the full one: Out of tolerance." in result.stdout
    assert "FINDINGS" not in result.stdout


@pytest.mark.slow
@pytest.mark.parametrize(("term", "sheet"), [("N_v", "starboard"), ("K_v", "port")])
def test_a_compact_set_with_one_term_a_tenth_off_is_out_on_either_side(
    term: str, sheet: str
) -> None:
    file = load_vessel("bb2")
    factors = as_filed(file)
    candidate = Candidate(file, "modified")
    candidate.take([(1.1 if name == term else 1.0) * factors[name] for name in candidate.terms])
    turns = [leg for leg in guide_legs(file) if leg.name == "turn" and sheet in leg.title]

    judged = [judgements for _, judgements in Yardstick(file, turns).judged(candidate)]

    assert any(one.verdict == BEYOND_TOLERANCE for judgements in judged for one in judgements)


def test_without_its_factors_and_extra_terms_the_set_of_1969_is_out_in_turns(
    tmp_path: Path,
) -> None:
    path = tmp_path / "boat.toml"
    path.write_text(without_reduction(load_vessel("bb2").text), encoding="utf-8")
    file = load_vessel(str(path))
    (leg,) = (
        leg for leg in guide_legs(file) if leg.title == "turn, rudder 15 deg, starboard, 5 kn"
    )
    flown = fly_all(path, [leg.task(file, "full"), leg.task(file, "modified")], 1, lambda: None)
    full, other = flown.values()
    assert isinstance(full, Flight)
    assert isinstance(other, Flight)

    judged = {one.quantity: one for one in verdicts.judge(leg.manoeuvre, full, other)}

    assert judged["steady diameter"].verdict == BEYOND_TOLERANCE
    assert (judged["steady diameter"].difference or 0.0) < -0.3 * (
        judged["steady diameter"].full or 0.0
    )


def without_reduction(text: str) -> str:
    """Return a vessel file without the tables of its reduction."""
    tables = r"^\[(compact|compensation\.\w+|reduction)\][^\[]*(\[\n[^\]]*\]\n)?"
    return re.sub(tables, "", text, flags=re.MULTILINE)


@pytest.mark.slow
def test_the_guide_says_what_the_dropped_coefficients_do(book: GuideContents) -> None:
    effect = {
        drop.coefficient: drop.percent["turn: steady diameter"] or 0.0 for drop in book.guide.drops
    }

    assert effect["N_avr"] < -10.0  # N_rar and others make up for it
    assert "N_rar" not in effect
    assert "X_vr" not in effect
    assert "M_star" in effect  # of the 60 of 1969, and dropped here


def test_what_was_found_in_1969_is_judged_with_figures(book: GuideContents) -> None:
    found = {one.title: one for one in book.guide.findings}

    verdict = {title: one.verdict for title, one in found.items()}
    assert verdict == {
        "Stern planes reverse": "holds",
        "Depth in turns": "holds in part",
        "Roll in turns": "holds in part",
        "Nonlinear vertical terms": "holds in part",
        "Euler at 1 s": "holds",
        "Adams at 0.5 s": "holds",
        "Lagged accelerations": "holds",
    }
    assert all(re.search(r"\d", one.words) for one in found.values())
    rows = {row[0]: row[-1] for row in found["Depth in turns"].rows}
    assert rows["Z_rr"] == "depth is lost"
    assert rows["M_vv"] == "not in this hull's data"


def test_adams_is_fine_at_its_own_step_and_euler_of_no_use_at_twice_it(book: GuideContents) -> None:
    worst: dict[tuple[str, float], float] = {}
    for run in book.guide.steps:
        if run.rates == "lagged":
            key = run.scheme, run.step_s
            worst[key] = max(worst.get(key, 0.0), run.percent or np.inf)

    assert worst["Adams 2", 0.5] < 1.0
    assert worst["Adams 2", 1.5] > 100.0  # roll grows, as was seen in 1969
    assert worst["Euler", 1.0] > 100.0


# --- the document


@pytest.mark.slow
def test_the_same_guide_twice_is_the_same_page(book: GuideContents, page: str) -> None:
    later = assemble_guide(book.file, book.legs, "2026-01-01 00:00:01 UTC", book.flown)

    assert guide_page.html_page(later, None).replace("00:00:01", "00:00:00") == page


def test_the_page_stands_alone_and_its_chapters_are_linked(page: str) -> None:
    assert not re.search(r'(?:src|href)="(?!#)', page)
    assert "http" not in page.split('<script type="application/json"', maxsplit=1)[0]
    links = set(re.findall(r'href="#([^"]+)"', page))
    assert len(links) > 30
    assert links <= set(re.findall(r'id="([^"]+)"', page))
    assert page.count("<svg") > 100


def test_verdicts_are_words(page: str) -> None:
    assert "Within tolerance" in page
    assert '<td class="bad">BEYOND</td>' in page
    assert '<td class="good">within</td>' in page


def test_the_summary_fits_a_terminal(book: GuideContents) -> None:
    text = render(book.guide, None)

    assert max(map(len, text.splitlines())) <= 79
    assert text.isascii()
    assert text.endswith("Within tolerance.")


@pytest.mark.process
@pytest.mark.skipif(find_browser() is None, reason="no browser here")
@pytest.mark.slow  # the whole guide is flown again in this lane
def test_a_browser_opens_the_page_without_complaint(page: str, tmp_path: Path) -> None:
    path = tmp_path / "guide.html"
    path.write_text(page, encoding="utf-8")

    done = subprocess.run(
        [
            str(find_browser()),
            *("--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr"),
            f"--user-data-dir={tmp_path / 'profile'}",
            "--dump-dom",
            path.as_uri(),
        ],
        capture_output=True,
        text=True,
        timeout=100,
        check=True,
    )

    assert "CONSOLE" not in done.stderr
    assert done.stdout.count("<svg") == page.count("<svg")


# --- what is not judged


def unjudged(book: GuideContents, count: int) -> GuideContents:
    """Return the guide with nothing judged in its first sheets."""
    blank = tuple(replace(sheet, judgements={}) for sheet in book.guide.sheets[:count])
    sheets = (*blank, *book.guide.sheets[count:])
    passed = verdicts.passes_all([sheet.passed("modified") for sheet in sheets])
    return replace(book, guide=replace(book.guide, sheets=sheets, passed=passed))


def test_a_sheet_in_which_nothing_is_judged_is_counted_as_not_judged(book: GuideContents) -> None:
    some = unjudged(book, 2)
    judged = len(book.guide.sheets) - 2

    text, html = render(some.guide, None), guide_page.html_page(some, None)

    told = f"manoeuvres within tolerance, {judged} of {judged} judged, 2 not judged;"
    assert f"modified: {told}" in " ".join(text.split())
    assert f"The modified set: {told}" in html
    assert "not judged        -" in text.splitlines()[3]
    assert text.endswith("Within tolerance.")


def test_a_guide_in_which_nothing_is_judged_does_not_pass(book: GuideContents) -> None:
    nothing = unjudged(book, len(book.guide.sheets))

    assert not nothing.guide.passed
    assert render(nothing.guide, None).endswith("Nothing was judged.")
    assert "Nothing was judged" in guide_page.html_page(nothing, None)


# --- since a baseline


def figures(book: GuideContents) -> dict[str, Any]:
    """Return the guide as its JSON is read back."""
    found: dict[str, Any] = json.loads(json.dumps(asdict(book.guide)))
    return found


def test_nothing_moves_against_itself_by_either_file(
    book: GuideContents, page: str, tmp_path: Path
) -> None:
    files = {"guide.json": json.dumps(figures(book)), "guide.html": page}
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
        earlier = load_earlier(tmp_path / name, book.guide.vessel)

        assert compare_guides(earlier, figures(book)) == ()


def test_what_moved_is_named_and_verdicts_come_first(book: GuideContents) -> None:
    now = figures(book)
    row = now["sheets"][0]["judgements"]["modified"][1]
    row["other"] *= 1.01
    row["verdict"] = "changed"

    found = compare_guides(figures(book), now)

    name = f"{now['sheets'][0]['title']}: {row['quantity']}"
    assert [one.what for one in found] == [
        f"{name}, modified: verdict",
        f"{name} [{row['unit']}], modified",
    ]
    assert found[1].percent == pytest.approx(1.0 if row["other"] > 0.0 else -1.0)
    assert "MOVED SINCE THE BASELINE: 2" in render(book.guide, found)
    assert name in guide_page.html_page(book, found)


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("{}", "is no guide"),
        ("[1, 2]", "is no guide"),
        ("not json", "is no guide"),
        (
            '{"vessel": "another", "sheets": [], "findings": [], "steps": [], "trials": []}',
            "not of",
        ),
    ],
)
def test_a_file_that_is_no_guide_of_this_boat_is_refused(
    text: str, wrong: str, tmp_path: Path
) -> None:
    path = tmp_path / "old.json"
    path.write_text(text)

    with pytest.raises(ConfigError, match=wrong):
        load_earlier(path, "BB2")
    with pytest.raises(ConfigError, match="No such file"):
        load_earlier(tmp_path / "none.json", "BB2")


# --- the commands


def ask(command: Any, *words: str) -> Result:
    return CliRunner().invoke(command, words, catch_exceptions=True)


def test_a_manoeuvre_is_told_on_a_page_with_an_example_in_its_help(tmp_path: Path) -> None:
    csv = str(tmp_path / "turn.csv")
    done = ask(manoeuvre, "turn", "bb2", "--angle", "20", "--csv", csv)

    assert done.exit_code == 0, done.output
    assert max(map(len, done.output.splitlines())) <= 79
    assert re.search(r"^  advance +\d+\.?\d* +m$", done.output, re.MULTILINE)
    series = load_series(Path(csv))
    assert {"t", "u", "z", "psi", "delta_r"} <= set(series.columns)
    assert series.t[-1] == 300.0
    assert "Example:  trainer boat manoeuvre" in ask(manoeuvre, "--help").output


def test_a_manoeuvre_as_json_has_every_measure() -> None:
    done = ask(manoeuvre, "zigzag-20", "bb2", "--equations", "modified", "--json")

    told = json.loads(done.stdout)
    numbers = {"angle": 20.0, "execute": 20.0, "duration": 300.0}
    assert told["parameters"] == {**numbers, "side": "starboard"}
    assert told["method"]["rates"] == "lagged"
    assert {"heading peak 1", "heading overshoot 1"} <= {one["name"] for one in told["measures"]}


def test_the_manoeuvres_are_listed() -> None:
    done = ask(manoeuvre, "--list")

    assert done.exit_code == 0
    assert "zigzag-20" in done.output


@pytest.mark.parametrize(
    ("words", "wrong"),
    [
        (["loop", "bb2"], "no manoeuvre 'loop'"),
        (["bb2", "turn"], "the manoeuvre comes first: trainer boat manoeuvre turn bb2"),
        (["utmost-acceleration", "bb2", "--speed", "5"], "starts from rest"),
        (["spiral", "bb2", "--duration", "60"], "no such parameter"),
    ],
)
def test_what_cannot_be_flown_is_refused(words: list[str], wrong: str) -> None:
    done = ask(manoeuvre, *words)

    assert isinstance(done.exception, ConfigError)
    assert wrong in str(done.exception)


def test_a_boat_that_is_lost_gives_exit_code_1() -> None:
    done = ask(manoeuvre, "meander", "remus100", "--speed", "4.5")

    assert done.exit_code == 1
    assert "LOST: pitch is" in done.output


def test_the_guide_as_a_command_writes_moves_and_leaves_by_the_verdict(
    book: GuideContents, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("trainer.cli.workshop.guide.write_guide", lambda *_: book)
    old, html = tmp_path / "old.json", tmp_path / "guide.html"
    old.write_text(json.dumps(figures(book)))

    done = ask(guide, "bb2", "--baseline", str(old), "--html", str(html), "--json")

    assert done.exit_code == 0
    told = json.loads(done.stdout)
    assert told["moved"] == []
    assert told["checksums"]["bb2.toml"]
    assert "Nothing moved." in html.read_text()
    failed = replace(book, guide=replace(book.guide, passed=False))
    monkeypatch.setattr("trainer.cli.workshop.guide.write_guide", lambda *_: failed)
    assert ask(guide, "bb2").exit_code == 1
    assert "Out of tolerance." in ask(guide, "bb2").output


def test_a_page_that_cannot_be_written_is_told(
    book: GuideContents, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("trainer.cli.workshop.guide.write_guide", lambda *_: book)
    full = ask(guide, "bb2", "--html", "/dev/full")

    assert isinstance(full.exception, ConfigError)
    assert "--html /dev/full: cannot be written: No space left" in str(full.exception)


def test_names_of_anybody_s_making_come_out_as_text(book: GuideContents) -> None:
    evil = '<script>alert("x")</script>'
    finding = replace(book.guide.findings[0], title=evil, claim=evil, words=evil)
    named = replace(book.guide, vessel=evil, findings=(finding, *book.guide.findings[1:]))
    text = guide_page.html_page(replace(book, guide=named), None)
    page, _, data = text.partition('<script type="application/json"')
    assert "<script" not in page
    assert page.count("&lt;script&gt;alert(&#34;x&#34;)&lt;/script&gt;") == 5
    assert data.count("</script>") == 1  # its own end
