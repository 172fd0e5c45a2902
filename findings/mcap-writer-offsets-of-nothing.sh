#!/usr/bin/env bash
# Does the summary of an MCAP file point only at groups of records that are there?
#
# Behaviour: the writer of the format's own Python library, left at its defaults, writes a summary
#   offset for attachment and metadata indexes of a file that has neither: a group of length 0. The
#   format's own reader takes the file; a checker by another author counts two errors. With
#   index_types of what is there alone the same messages have no such group, and no error.
# Guess before: a writer states an offset only of a group that it wrote.
# Versions: mcap 1.6.0, pymcap-cli 0.34.0
# Source: the format's page at mcap.dev, Summary Offset; mcap/writer.py, finish
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv python
python/bin/pip install -q --disable-pip-version-check mcap==1.6.0 pymcap-cli==0.34.0
cat > seen.py << 'PY'
import subprocess, sys
from pathlib import Path

from mcap.reader import make_reader
from mcap.records import SummaryOffset
from mcap.stream_reader import StreamReader
from mcap.writer import IndexType, Writer


def write(name, **options):
    """Write two messages, no attachment and no metadata."""
    with open(name, "wb") as file:
        writer = Writer(file, **options)
        writer.start(profile="", library="")
        schema = writer.register_schema("s", "jsonschema", b"{}")
        channel = writer.register_channel("/a", "json", schema)
        for at in (1, 2):
            writer.add_message(channel, at, b"{}", at, at)
        writer.finish()


def seen(name):
    """Return messages read, empty groups, and whether another checker finds no error."""
    with open(name, "rb") as file:
        count = len([*make_reader(file).iter_messages()])
    with open(name, "rb") as file:
        records = [*StreamReader(file).records]
    empty = [one for one in records if isinstance(one, SummaryOffset) and not one.group_length]
    tool = Path(sys.executable).parent / "pymcap-cli"
    checked = subprocess.run([tool, "doctor", name], capture_output=True)
    return count, len(empty), checked.returncode == 0


write("default.mcap")
write("what-is-there.mcap", index_types=IndexType.CHUNK | IndexType.MESSAGE)
for name in ("default.mcap", "what-is-there.mcap"):
    print(f"{name}: {seen(name)[0]} messages read, {seen(name)[1]} empty groups, "
          f"no error: {seen(name)[2]}")
sys.exit(0 if (seen("default.mcap"), seen("what-is-there.mcap"))
         == ((2, 2, False), (2, 0, True)) else 1)
PY
python/bin/python seen.py
