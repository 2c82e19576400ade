"""Poisson draws of small expectations, from the definition of ChaCha and Knuth's method alone.

    python poisson.py

Prints the draws for the expectations 0.5, 3 and 11 in the voxels 0, 1 and 2 with the seed 20261121,
which are pinned in `src/poisson.rs`. ChaCha is that of D. J. Bernstein, with 8 rounds, a counter and
a nonce of 64 bits each: the key is the seed in 8 bytes, the lowest first, and 24 bytes of 0; the nonce
is the index of the voxel. A number between 0 and 1 is the upper 53 of 64 bits.
"""

from math import exp

ROUNDS = 8
MASK = 0xFFFFFFFF


def quarter(state, a, b, c, d):
    for x, y, z, turn in ((a, b, d, 16), (c, d, b, 12), (a, b, d, 8), (c, d, b, 7)):
        state[x] = (state[x] + state[y]) & MASK
        mixed = state[z] ^ state[x]
        state[z] = (mixed << turn | mixed >> (32 - turn)) & MASK


def block(seed, counter, nonce):
    start = [int.from_bytes(b"expand 32-byte k"[i : i + 4], "little") for i in range(0, 16, 4)]
    start += [seed & MASK, seed >> 32] + [0] * 6
    start += [counter & MASK, counter >> 32, nonce & MASK, nonce >> 32]
    state = list(start)
    for _ in range(ROUNDS // 2):
        for i in range(4):
            quarter(state, i, 4 + i, 8 + i, 12 + i)
        for i in range(4):
            quarter(state, i, 4 + (i + 1) % 4, 8 + (i + 2) % 4, 12 + (i + 3) % 4)
    return [(a + b) & MASK for a, b in zip(state, start)]


def uniform(seed, nonce):
    counter = 0
    while True:
        words = block(seed, counter, nonce)
        for low, high in zip(words[::2], words[1::2]):
            yield ((high << 32 | low) >> 11) / 2**53
        counter += 1


def draw(expected, seed, voxel):
    numbers = uniform(seed, voxel)
    count, product = 0, next(numbers)
    while product > exp(-expected):
        product *= next(numbers)
        count += 1
    return count


for voxel, expected in enumerate([0.5, 3.0, 11.0]):
    print(expected, draw(expected, 20261121, voxel))
