"""When a double pendulum first turns over, from 512 x 512 starts, as arrays and as a picture, computed once."""
from pendulumd import Pendulum
axes = [dict(vary="theta", arm=arm, start=-3, stop=3, count=512) for arm in (1, 2)]
job = Pendulum(length=[1, 1], mass=[1, 1], parent=[0, 1]).ensemble(grid=axes, duration=30, observables=["first_flip"], rtol=1e-9, job=True)
flips, picture = job.result(), job.save("flips.png")
print(flips.first_flip_time.reshape(512, 512).shape, f"{(flips.first_flip_arm > 0).mean():.0%} turn over", open(picture, "rb").read(4))
