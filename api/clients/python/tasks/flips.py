"""The well-known figure: when a double pendulum first turns over, from 512 x 512 starts, as arrays and as a picture."""
import sys
from pendulumd import Pendulum
count = int(sys.argv[1]) if len(sys.argv) > 1 else 512
double = Pendulum(length=[1, 1], mass=[1, 1], parent=[0, 1])
axes = [dict(vary="theta", arm=arm, start=-3, stop=3, count=count) for arm in (1, 2)]
flips = double.ensemble(grid=axes, duration=30, observables=["first_flip"], rtol=1e-9)
time = flips.first_flip_time.reshape(count, count)
open("flips.png", "wb").write(double.client.call("ensembles", double.request(grid=axes, duration=30, observables=["first_flip"], rtol=1e-9), accept="image/png"))
print(time.shape, f"{(flips.first_flip_arm > 0).mean():.0%} turn over")
