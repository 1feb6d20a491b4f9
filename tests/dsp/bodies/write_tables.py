"""Writes the tables that dsp/bodies/radiation keeps: python -m tests.dsp.bodies.write_tables."""

import math
from pathlib import Path

import numpy as np

from carom.dsp.bodies.radiation.thin import strip

FOLDER = Path(__file__).parents[3] / "dsp/bodies/radiation"
REACH, POINTS = (0.005, 40.0), 160


def strip_table() -> str:
    x = np.geomspace(*REACH, POINTS)
    impedance = np.array([strip(each) for each in x])
    columns = {"RESISTANCE": impedance.real, "MASS": -impedance.imag / (math.pi * x)}
    head = "A flat strip in air, by `thin.strip`, at equal steps of ln x; written by tests/dsp/bodies/write_tables.py."
    text = f'"""{head}"""\n'
    text += f"\nREACH = {REACH}\n" + '"""k b, from and to."""\n'
    said = {"RESISTANCE": "per length, over rho c b", "MASS": "per length, over rho pi b^2"}
    for name, column in columns.items():
        rows = [", ".join(f"{value:.6g}" for value in column[i : i + 8]) for i in range(0, POINTS, 8)]
        text += f"{name} = (\n" + "".join(f"    {row},\n" for row in rows) + f')  # fmt: skip\n"""{said[name]}."""\n'
    return text


if __name__ == "__main__":
    (FOLDER / "strip_table.py").write_text(strip_table(), encoding="utf-8")
