"""Traces of fractures: reading and writing the CSV files, clipping to a rectangle. Other formats are read by map_formats.

A CSV file has the header `x1,y1,x2,y2,trace` and one straight segment a row, in metres, x east, y north. The rows of one
trace stand together, in order; the last column names the trace.
"""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from femdem.network.map_formats import GEOJSON, LAYERS, FormatError, read_lines

HEADER = ["x1", "y1", "x2", "y2", "trace"]
MOST_LISTED = 10  # errors of one file that are listed


class TraceError(Exception):
    """The traces cannot be used; the message says where and why."""


@dataclass
class Traces:
    """Segments of traces."""

    segment: np.ndarray  # ends of each segment: x1, y1, x2, y2 (segments, 4) [m]
    trace: np.ndarray  # index into name of the trace that each segment is of (segments)
    name: list  # name of each trace

    @property
    def length(self):
        """Length of all segments together [m]."""
        return float(np.hypot(*(self.segment[:, 2:] - self.segment[:, :2]).T).sum())

    @property
    def used(self):
        """Number of traces that have a segment."""
        return len(np.unique(self.trace))

    @property
    def extent(self):
        """Smallest rectangle around the segments: x0, y0, x1, y1 [m]."""
        points = self.segment.reshape(-1, 2)
        return (*points.min(axis=0).tolist(), *points.max(axis=0).tolist())


def read_traces(path):
    """Read a file of traces; all that is wrong with it is said in one TraceError."""
    path = Path(path)
    if path.suffix.lower() in GEOJSON + LAYERS:
        return read_map(path)
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = list(csv.reader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise TraceError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from error
    if not rows:
        raise TraceError(f"{path}: the file is empty; the first line must be {','.join(HEADER)}")
    header = [word.strip().lower() for word in rows[0]]
    if header != HEADER:
        raise TraceError(f"{path}:1: the header is '{','.join(rows[0])}', it must be '{','.join(HEADER)}'")
    segments, names, wrong = [], [], []
    for line, row in enumerate(rows[1:], start=2):
        if not any(word.strip() for word in row):
            continue
        if len(row) != len(HEADER):
            wrong.append(f"{path}:{line}: {len(row)} values, {len(HEADER)} are expected")
            continue
        numbers = [_number(word) for word in row[:4]]
        bad = [f"{name} = '{word}'" for name, word, x in zip(HEADER, row, numbers, strict=False) if x is None]
        if bad:
            wrong.append(f"{path}:{line}: {', '.join(bad)} is not a finite number")
            continue
        segments.append(numbers)
        names.append(row[4].strip())
    if wrong:
        rest = len(wrong) - MOST_LISTED
        raise TraceError("\n".join(wrong[:MOST_LISTED] + ([f"{path}: and {rest} more"] if rest > 0 else [])))
    if not segments:
        raise TraceError(f"{path}: there are no segments in the file")
    number = {}
    trace = [number.setdefault(name, len(number)) for name in names]
    return Traces(np.array(segments), np.array(trace), list(number))


def read_map(path):
    """Read traces from a file of a geographic information system."""
    try:
        lines, others = read_lines(path)
    except FormatError as error:
        raise TraceError(str(error)) from error
    pieces = [(name, np.hstack([points[:-1], points[1:]])) for name, points in lines if len(points) > 1]
    if not pieces:
        raise TraceError(f"{path}: there are no lines in the file ({others} other geometries)")
    number = {}
    trace = [number.setdefault(name, len(number)) for name, piece in pieces for _ in piece]
    return Traces(np.vstack([piece for _, piece in pieces]), np.array(trace), list(number))


def write_traces(path, traces):
    """Write a file of traces, to the nanometre."""
    with Path(path).open("w", newline="", encoding="utf-8") as file:
        file.write(",".join(HEADER) + "\n")
        for ends, trace in zip(traces.segment, traces.trace, strict=True):
            # adding 0.0 turns a negative zero into zero
            file.write(",".join(f"{round(x, 9) + 0.0:.9f}" for x in ends) + f",{traces.name[trace]}\n")


def clip(traces, window):
    """The parts of the traces inside a rectangle x0, y0, x1, y1 [m] (Liang and Barsky's way)."""
    start, along = traces.segment[:, :2], traces.segment[:, 2:] - traces.segment[:, :2]
    low, high = np.zeros(len(start)), np.ones(len(start))
    for axis in range(2):
        with np.errstate(divide="ignore", invalid="ignore"):
            to_low = (window[axis] - start[:, axis]) / along[:, axis]
            to_high = (window[axis + 2] - start[:, axis]) / along[:, axis]
        level = along[:, axis] == 0.0
        inside = (start[:, axis] >= window[axis]) & (start[:, axis] <= window[axis + 2])
        enter = np.where(level, np.where(inside, 0.0, 2.0), np.fmin(to_low, to_high))
        leave = np.where(level, 1.0, np.fmax(to_low, to_high))
        low, high = np.maximum(low, enter), np.minimum(high, leave)
    keep = high > low
    first = start + low[:, None] * along
    last = np.where((high == 1.0)[:, None], traces.segment[:, 2:], start + high[:, None] * along)
    corners = np.array(window, dtype=float)
    ends = [np.clip(end, corners[:2], corners[2:]) for end in (first, last)]
    return Traces(np.hstack(ends)[keep], traces.trace[keep], traces.name)


def _number(word):
    """Value of a text, None when it is not a finite number."""
    try:
        value = float(word)
    except ValueError:
        return None
    return value if np.isfinite(value) else None
