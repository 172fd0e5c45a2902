"""Names on disk, on the wire and in people's files stay, whatever the code calls things."""

import json

import pytest
from helpers.outside_names import LIST, outside_names

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")


def test_no_name_that_others_have_has_changed() -> None:
    listed = json.loads(LIST.read_text(encoding="utf-8"))
    now = json.loads(json.dumps(outside_names()))
    changed = {kind: (names, now.get(kind)) for kind, names in listed.items() if names != now[kind]}
    assert not changed, "a promise: python -m helpers.outside_names takes it back (see there)"
    assert set(now) == set(listed)
