"""The stored outputs of the shipped check cases, configs/check-cases/*.csv that this trainer flew.

    python -m helpers.check_cases

in the folder of the tests flies every run that has a file, and writes the file anew: after a change
of the core. It names what is then beyond the spread that a case states.
"""

from trainer.analysis.check_cases import STORED_DIGITS, CaseOutputs, fly_case, fly_run
from trainer.config.exercise.check_case import TIME_COLUMN, CheckCase, case_paths, load_case


def outputs_text(case: CheckCase, outputs: CaseOutputs) -> str:
    """Return the CSV text of a run, as files of check cases are written."""
    lines = [",".join((TIME_COLUMN, *case.spread))]
    for i, t in enumerate(case.times):
        row = (f"{outputs.columns[name][i] + 0.0:.{STORED_DIGITS}g}" for name in case.spread)
        lines.append(",".join((f"{t:.10g}", *row)))
    return "\n".join(lines) + "\n"


def renew_outputs() -> list[str]:
    """Write the outputs of all our runs; return what is beyond its spread."""
    faults = []
    for path in case_paths(None):
        case = load_case(path)
        for run in case.runs:
            if run.integrator and run.file:
                text = outputs_text(case, fly_run(case, run))
                (path.parent / run.file).write_text(text, encoding="utf-8")
        faults += [
            f"{case.name}: {each.run} beside {each.beside}: {one.channel} differs by "
            f"{one.largest:.3g}, stated {one.spread:g}"
            for each in fly_case(case).comparisons
            for one in each.differences
            if one.channel in each.beyond
        ]
    return faults


if __name__ == "__main__":
    print("\n".join(renew_outputs()) or "all within the spreads")
