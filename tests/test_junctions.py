"""Junctions of fractures do not know how their mesh was drawn (tests/junctions.py says how that is measured)."""

import itertools

import junctions
import pytest

# One angle on either side of 60 degrees, where walls used to go on or to end
CASES = [
    (kind, angle, slip) for kind, angle, slip in itertools.product(junctions.KINDS, (30, 59, 61, 90), (0, 3))
]


@pytest.mark.parametrize(("kind", "angle", "slip"), CASES)
def test_the_drawing_does_not_matter(kind, angle, slip, tmp_path, femdem):
    assert femdem.is_file()
    rows, _ = junctions.compare(junctions.scene_of(kind, angle, 0.05, slip), tmp_path)
    junctions.print_rows(rows)
    assert not any(row["message"] for row in rows)
    for row in rows:
        for quantity in junctions.QUANTITIES:
            off = row[f"{quantity}_scene"]
            assert off <= junctions.SAME, f"{row['variant']}: {quantity} differs by {off:.1e}"
        assert row["overlap_mm"] <= row["allowed_mm"], f"{row['variant']}: rock in rock"
