"""The fields of a sentence to an instrument, as NMEA 0183 writes places and numbers."""

import pytest

from trainer.io.nmea import latitude, longitude, number


@pytest.mark.parametrize(
    ("degrees", "field"),
    [
        (54.5, ("5430.00000", "N")),
        (-33.8571428, ("3351.42857", "S")),
        (0.0, ("0000.00000", "N")),
        (9.9999999999, ("1000.00000", "N")),  # minutes never come to 60
    ],
)
def test_a_latitude_is_whole_degrees_and_minutes(degrees: float, field: tuple[str, str]) -> None:
    assert latitude(degrees) == field


def test_a_longitude_has_three_digits_of_degrees() -> None:
    assert longitude(10.1) == ("01006.00000", "E")
    assert longitude(-179.99999999) == ("18000.00000", "W")


def test_a_number_has_its_decimals_and_no_minus_before_zero() -> None:
    assert number(3.14159, 2) == "3.14"
    assert number(-0.001, 1) == "0.0"
    assert number(None, 1) == ""
