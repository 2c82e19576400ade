"""Writes torus.npy: a plasma torus on 40 x 40 x 16 points, in photons per cubic centimetre and second.

The axes are z, y, x; x and y go from -8 to 8 and z from -2.5 to 2.5 Jupiter radii. A ring of 5.9
radii, 0.9 wide and 0.6 high, is brighter on its dusk side and tilted by 7 degrees, as the magnetic
equator of Jupiter is. It is a shape to look at, not a model of the torus.
"""

import math
import struct
from pathlib import Path

NODES = {"x": (40, 8.0), "y": (40, 8.0), "z": (16, 2.5)}
RING_RADIUS, WIDTH, HEIGHT = 5.9, 0.9, 0.6
TILT = math.radians(7.0)
PEAK = 0.02


def nodes(axis):
    count, end = NODES[axis]
    return [-end + 2.0 * end * i / (count - 1) for i in range(count)]


def rate(x, y, z):
    along = x * math.cos(TILT) + z * math.sin(TILT)
    above = z * math.cos(TILT) - x * math.sin(TILT)
    radius = math.hypot(along, y)
    dusk = 1.0 + 0.3 * math.cos(math.atan2(y, along) - 1.0)
    return PEAK * dusk * math.exp(-(((radius - RING_RADIUS) / WIDTH) ** 2) - (above / HEIGHT) ** 2)


def main():
    shape = tuple(NODES[axis][0] for axis in "zyx")
    header = f"{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}".encode()
    header += b" " * (-(len(header) + 11) % 64) + b"\n"
    values = [rate(x, y, z) for z in nodes("z") for y in nodes("y") for x in nodes("x")]
    with open(Path(__file__).with_name("torus.npy"), "wb") as file:
        file.write(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header)
        file.write(struct.pack(f"<{len(values)}f", *values))


if __name__ == "__main__":
    main()
