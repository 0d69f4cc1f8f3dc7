"""20 000 random starts of a double pendulum, 500 instants each with their energies, as records of single precision on disk."""
import numpy as np
from pendulumd import Pendulum
starts = dict(count=20000, seed=7, draw=[dict(vary="theta", arm=arm, distribution="uniform", low=-3, high=3) for arm in (1, 2)])
table = np.memmap(Pendulum(length=[1, 1], mass=[1, 1], parent=[0, 1]).ensemble(random=starts, times=dict(stop=10, count=500), observables=["trajectory"],
    output=["theta", "thetad", "energy"], columns=["theta", "thetad", "energy_total"], number="float32", save="dataset.bin"),
    [("theta", "<f4", 2), ("thetad", "<f4", 2), ("energy_total", "<f4")], "r").reshape(-1, 500)
print(table.shape, table.itemsize, "starts within 3 rad:", abs(table["theta"][:, 0]).max() <= 3, "energies kept:", np.ptp(table["energy_total"], axis=1).max() < 1e-4)
