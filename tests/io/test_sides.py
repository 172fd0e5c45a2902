"""Angles with their side."""

import pytest

from trainer.io.sides import ANGLE_SIDES, sided


@pytest.mark.parametrize(
    ("name", "angle", "said"),
    [
        ("stern", -6.0, "6.0 dive"),
        ("rudder", -10.0, "10.0 left"),
        ("bow", 0.3, "0.3 rise"),
        ("bow", 0.049, "0.0"),
        ("stern", -0.049, "0.0"),
        ("stern", -0.051, "0.1 dive"),
        ("pitch", -2.0, "2.0 down"),
        ("heel", 12.34, "12.3 stbd"),
    ],
)
def test_an_angle_is_said_with_its_side_unless_it_is_written_as_zero(
    name: str, angle: float, said: str
) -> None:
    assert sided(angle, ANGLE_SIDES[name]) == said


def test_the_unit_stands_before_the_side() -> None:
    assert sided(-0.3, ANGLE_SIDES["stern"], 0, "deg") == "0 deg"
    assert sided(-6.0, ANGLE_SIDES["stern"], 0, "deg") == "6 deg dive"
