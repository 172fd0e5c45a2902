"""The C header of an exported core, made from the records' dtypes.

``library`` and ``wasm`` write it beside the compiled core. It is made of the dtypes, so that
offsets in C are those of the records, whatever changes there.
"""

import inspect
import re
from collections.abc import Iterator
from types import ModuleType
from typing import Final

import numpy as np

from trainer import __version__
from trainer.boat.boat import Boat
from trainer.core import state, vessel
from trainer.core.ballast import ballast
from trainer.core.digest import core_digest
from trainer.core.state import SCRATCH, STATE
from trainer.core.update import WATCHED_NAMES
from trainer.core.vessel import COMPACT, VESSEL

HEADER_START: Final = """\
/* The tick of one submarine, compiled from trainer {version}.

   {boat}
   {equations} set, {rates} rates, {integrator} at {step:g} s, for {cpu}

   SI and radians: u v w [m/s], p q r [rad/s], phi theta psi [rad], x y z [m], dots their rates
   when the last tick began.
   Body axes x forward, y starboard, z to the keel; earth axes x north, y east, z down. psi is
   positive to starboard, theta bow up, phi starboard side down. Plane signs are carried by the
   coefficients.

   The tick has no memory, no globals and no calls: any number of boats, from any thread. The same
   numbers go in, the same bits come out, on every machine. */

#ifndef TRAINER_CORE_H
#define TRAINER_CORE_H

#ifdef __cplusplus
extern "C" {{
#endif

#define TRAINER_VERSION "{version}"
#define TRAINER_CORE_DIGEST "{digest}"
#define TRAINER_STEP_S {step!r}
#define TRAINER_STATE_DOUBLES {state}
#define TRAINER_SCRATCH_DOUBLES {scratch}
"""
HEADER_END: Final = """
/* Work space: nothing in it is read from one tick to the next. Begin with zeros. */
struct trainer_scratch {{ double work[TRAINER_SCRATCH_DOUBLES]; }};

/* The boat, and where it starts: in trim, on its own orders. Copy the start, change the copy. */
extern const struct trainer_vessel trainer_vessel;
extern const struct trainer_compact trainer_compact;
extern const struct trainer_state trainer_start;

/* What this core was made from, in lines of text. A line for each order that only writes numbers:
   order WORDS;LOW;HIGH;FACTOR;TURN;PLACE=RULE:ARGUMENT,... PLACE is that of the state above. */
extern const char trainer_card[];

/* Advance the state by one step. Return 0, or else the state is as it was and the status is
   1 + the place in the list of the number that is beyond all bounds:
   {watched}. */
int trainer_tick(const struct trainer_vessel *vessel, const struct trainer_compact *compact,
                 struct trainer_state *state, struct trainer_scratch *scratch);

#ifdef __cplusplus
}}
#endif

#endif
"""
# Names that hosts were written for, of fields that the core calls otherwise.
PUBLISHED_NAMES: Final = {field: name for name, field in vessel.INVERTED_NAMES.items()}
COMMENT_PATTERN: Final = re.compile(r'^\s*(?:\*?\()?"(\w+)"[^#\n]*#\s*(.+)$', re.MULTILINE)


def header_text(boat: Boat, cpu: str) -> str:
    """Return the header for ``boat`` compiled for the processor called ``cpu``."""
    method = boat.method
    head = HEADER_START.format(
        version=__version__,
        digest=core_digest(),
        boat=boat.file.name,
        equations=method.equations,
        rates=method.rates,
        integrator=method.integrator,
        step=method.step,
        cpu=cpu,
        state=STATE.itemsize // 8,
        scratch=SCRATCH.itemsize // 8,
    )
    structures = (
        (
            "trainer_state",
            STATE,
            field_comments(state),
            "All that evolves, standing orders included.",
        ),
        ("trainer_vessel", VESSEL, field_comments(vessel, ballast), "What the boat is: constants."),
        ("trainer_compact", COMPACT, field_comments(vessel), "The constants of the compact set."),
    )
    blocks = [record_structure(*each) for each in structures]
    lines = [", ".join(WATCHED_NAMES[i : i + 12]) for i in range(0, len(WATCHED_NAMES), 12)]
    return "\n".join([head, *blocks, HEADER_END.format(watched=",\n   ".join(lines))])


def field_comments(*modules: ModuleType) -> dict[str, str]:
    """Return the comments in the core's modules beside the names of a record's fields."""
    comments: dict[str, str] = {}
    for module in modules:
        comments |= dict(COMMENT_PATTERN.findall(inspect.getsource(module)))
    return comments


def fields_of(kind: np.dtype) -> dict[str, tuple[int, tuple[int, ...]]]:
    """Return offset [bytes] and shape of each name in a record, in order of offsets."""
    fields = {name: (at[1], at[0].shape) for name, at in (kind.fields or {}).items()}
    fields.pop("whole", None)
    return dict(sorted(fields.items(), key=lambda item: item[1][0]))


def record_members(kind: np.dtype) -> Iterator[tuple[str, int, tuple[int, ...]]]:
    """Yield name, offset [bytes] and shape of what a record holds, each number once.

    Where single numbers and a block of them share an offset the numbers count.
    """
    fields = fields_of(kind)
    single = {offset for offset, shape in fields.values() if not shape}
    for name, (offset, shape) in fields.items():
        if not shape or offset not in single:
            yield name, offset, shape


def record_structure(name: str, kind: np.dtype, said: dict[str, str], title: str) -> str:
    """Return the C structure of a record. One that is not as large does not compile."""
    lines = [f"/* {title} */", f"struct {name} {{"]
    blocks = {at: said[block] for block, (at, _) in fields_of(kind).items() if block in said}
    for member, offset, shape in record_members(kind):
        extent = "".join(f"[{count}]" for count in shape)
        remark = said.get(member, blocks.get(offset, "")).replace("*/", "* /")
        published = PUBLISHED_NAMES.get(member, member)
        lines.append(f"    double {published}{extent};  /* {offset // 8} {remark}".rstrip() + " */")
    size = f"sizeof(struct {name}) == {kind.itemsize}"
    check = f"typedef char {name}_has_its_size[{size} ? 1 : -1];"
    return "\n".join([*lines, "};", check, ""])
