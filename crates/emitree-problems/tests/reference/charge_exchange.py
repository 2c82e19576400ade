"""The cross section of charge exchange between H+ and H: Lindsay and Stebbings 2005,
doi:10.1029/2005JA011298. Prints energies in keV and cross sections in 1e-20 m2 for the unit test of
cubes/ena_ring.rs. Standard library only."""

from decimal import Decimal, getcontext

getcontext().prec = 40

for kev in (1, 10, 50, 100):
    energy = Decimal(kev)
    slow = (Decimal("4.15") - Decimal("0.531") * energy.ln()) ** 2
    fast = 1 - (-Decimal("67.3") / energy).exp()
    print(kev, f"{slow * (Decimal('4.5') * fast.ln()).exp():.20f}")
