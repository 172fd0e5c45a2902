"""Facts that the pages go by: who is here, who speaks, marks, degrees of casualties."""

from helpers.crewed import Crewed


def test_who_is_here_is_told_in_facts_with_who_has_command_and_who_is_ready(ship: Crewed) -> None:
    helm = ship.comes("helm")
    ship.comes("instructor")
    assert ship.say(helm, "ready")[0] == "ok"
    assert ship.say(helm, "name wheel")[0] == "ok"
    ship.say(helm, "who")

    assert ship.facts(helm, "stations")[-1] == "3"
    assert ship.facts(helm, "aboard")[-3:] == [
        "instructor,,command,line 1",
        f"helm,wheel,you ready,{helm.name}",
        "instructor,,,line 3",
    ]


def test_who_has_said_something_is_told_before_its_text(ship: Crewed) -> None:
    helm, observer = ship.comes("helm"), ship.comes("observer")
    ship.order("freeze")
    ship.say(helm, "rudder left 5")
    ship.say(observer, "mark well done, helm")

    assert ship.facts(observer, "said")[-1].startswith("helm,rudder left 5: ")
    assert ship.facts(ship.instructor, "said")[-1] == "observer,mark: well done, helm"
    assert not ship.events(observer, "order")[-1].startswith("helm,")


def test_marks_are_told_with_their_reasons_in_facts(drill: Crewed) -> None:
    helm = drill.comes("helm")
    drill.fly(20)
    drill.settle(lambda: drill.conduct.marks.found)
    assert drill.facts(drill.instructor, "reason") == [
        ",branch 1: 42",
        ",Stern jam answered: does not count",
    ]
    assert drill.facts(helm, "reason") == []

    drill.order("release marks")
    assert drill.facts(helm, "reason") == [",branch 1: 42"]
    whole = [",branch 1: 42", ",Stern jam answered: does not count"]
    assert drill.facts(drill.instructor, "reason") == [*whole, *whole]
    assert drill.facts(drill.comes("instructor"), "reason") == whole


def test_usual_degrees_of_casualties_are_told_in_fields(ship: Crewed) -> None:
    ship.order("casualties")
    degrees = {fields.split(",")[0]: fields.split(",") for fields in _degrees(ship)}

    assert degrees["stern-hard-over"][4:] == ["deg", "dive", "dive", "rise"]
    assert degrees["flooding-aft"][4:] == ["cm2", ""]
    assert "stern-stuck" not in degrees


def _degrees(ship: Crewed) -> list[str]:
    return ship.facts(ship.instructor, "degree")
