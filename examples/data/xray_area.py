"""Writes xray_area.txt: an effective area against energy, a shape to look at and of no real telescope."""

import math

with open("xray_area.txt", "w", encoding="ascii") as file:
    file.write("# %ECSV 1.0\n# ---\n# datatype:\n")
    file.write("# - {name: energy, unit: keV, datatype: float64}\n")
    file.write("# - {name: area, unit: cm2, datatype: float64}\n")
    file.write("energy area\n")
    for step in range(48):
        energy = 0.25 * (step + 1)
        # A filter that absorbs below half a keV, a mirror that ends softly at some 6 keV.
        area = 1200 * math.exp(-((0.45 / energy) ** 3)) / (1 + (energy / 4.5) ** 4)
        file.write(f"{energy:g} {area:.1f}\n")
