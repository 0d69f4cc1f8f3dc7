"""A long motion as a job with a key of your own: after an interruption, the same program finds the job and continues the download."""
import numpy as np
from pendulumd import Pendulum
double = Pendulum(length=[1, 1], mass=[1, 1], parent=[0, 1])
job = double.run("0:2000:0.005", theta=[0.3, 0.2], output=["theta"], job="long-motion-1")
theta = np.load(job.save("long.npz", progress=True))["theta"]
print(theta.shape, "stays below 1 rad:", abs(theta).max() < 1)
