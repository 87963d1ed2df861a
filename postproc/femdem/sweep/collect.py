"""Numbers of a run, by specifications such as

    history.joint.shear_stress_MPa                              at the end of the run
    history.joint.shear_stress_MPa largest                      the largest of all rows
    edges.mean_shear_displacement_mm mean_by_length @ phase_1   over the block edges, at the end of a stage
    permeability.kxx_m2 @ t=0.05                                at the last output up to a time [s]

A specification is TABLE.COLUMN [HOW] [@ WHEN]. TABLE.csv is a table of the results. HOW is last (of tables by time), mean (of block
edges), median, least, largest, std, sum, or mean_by_length (block edges). WHEN is a stage or t=TIME; without it the end.
"""

import math
from dataclasses import dataclass

import numpy as np

from femdem.results import Edges, History, ResultsError

HOW = {
    "last": lambda values: values[-1],
    "mean": np.mean,
    "median": np.median,
    "least": np.min,
    "largest": np.max,
    "std": np.std,
    "sum": np.sum,
}
BY_LENGTH = "mean_by_length"
LATE = 1e-9  # relative: a time that is written with ten digits is not after itself


@dataclass
class Specification:
    """One number to collect."""

    table: str
    column: str
    how: str
    when: str

    @classmethod
    def parse(cls, text):
        """From its text"""
        # A column of a group may have blanks in its name: a last word is HOW only when it is one
        body, _, when = text.partition("@")
        words = body.split()
        how = words.pop() if len(words) > 1 and words[-1] in (*HOW, BY_LENGTH) else ""
        table, dot, column = " ".join(words).partition(".")
        if not dot or not table or not column:
            raise ResultsError(f"{text!r}: it must be TABLE.COLUMN [HOW] [@ STAGE or t=TIME]")
        if how == BY_LENGTH and table != "edges":
            raise ResultsError(f"{text!r}: {BY_LENGTH} is for edges alone")
        return cls(table, column, how or ("mean" if table == "edges" else "last"), when.strip())


def time_limit(when):
    """Time of t=TIME [s]; none for the name of a stage"""
    if not when.startswith("t="):
        return None
    try:
        return float(when[2:])
    except ValueError:
        raise ResultsError(f"{when}: TIME must be a number of seconds") from None


def last_place(times, stages, when, what):
    """Position of the last output up to WHEN"""
    limit = time_limit(when)
    here = (
        np.flatnonzero(times <= limit * (1 + LATE)) if limit is not None else np.flatnonzero(stages == when)
    )
    if not len(here):
        raise ResultsError(
            f"{what}: nothing at {when!r}; stages there are: {', '.join(dict.fromkeys(map(str, stages)))}"
        )
    return int(here[-1])


def collect(run, text):
    """The number a specification means, of a run"""
    wanted = Specification.parse(text)
    if wanted.table == "edges":
        edges = run.edges
        if wanted.when:
            fields = run.fields
            step = last_place(fields.times, np.array(fields.stages), wanted.when, "edges")
            edges = Edges.at(fields, step, run.edges)
        columns = edges.columns()
        if wanted.column not in columns or wanted.column == "group":
            raise ResultsError(f"edges.csv: no column {wanted.column!r}; there are: {', '.join(columns)}")
        values = columns[wanted.column]
        if wanted.how == BY_LENGTH:
            return float(np.average(values, weights=edges.length_m))
        return float(HOW[wanted.how](values)) if len(values) else math.nan
    table = History(run.directory / f"{wanted.table}.csv")
    values = table[wanted.column]
    if wanted.when:
        names = [str(group.get("name", "")) for group in run.deck.all("stage")]
        stages = np.array([names[int(number) - 1] for number in table["stage"]])
        values = values[: last_place(table["time_s"], stages, wanted.when, wanted.table) + 1]
    if not len(values):
        raise ResultsError(f"{table.path}: it has no rows")
    return float(HOW[wanted.how](values))
