"""20 000 random starts of a double pendulum, 500 instants each, as one array of single precision on disk."""
import sys
import numpy as np
from pendulumd import Pendulum
count, instants = int(sys.argv[1]) if len(sys.argv) > 1 else 20000, 500
double = Pendulum(length=[1, 1], mass=[1, 1], parent=[0, 1])
draw = [dict(vary="theta", arm=arm, distribution="uniform", low=-3, high=3) for arm in (1, 2)]
request = double.request(random=dict(count=count, seed=7, draw=draw), times=dict(stop=10, count=instants), observables=["trajectory"], output=["theta", "thetad"])
table = np.lib.format.open_memmap("dataset.npy", "w+", np.float32, (count, instants, 4))
for number, block in enumerate(double.client.stream("ensembles", request, rows=200 * instants)):
    table[200 * number:200 * (number + 1)] = np.hstack([block.theta, block.thetad]).reshape(-1, instants, 4)
print(table.shape, "finite:", np.isfinite(table).all(), "starts within 3 rad:", abs(table[:, 0, :2]).max() <= 3)
