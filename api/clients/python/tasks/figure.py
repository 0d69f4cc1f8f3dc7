"""A published figure: when two equal rods first turn over (Heyl 2008, "The double pendulum fractal"), with its curve 3 cos a + cos b = 2, within which they cannot."""
import numpy as np
from pendulumd import Pendulum
rods, angle = Pendulum(length=[1, 1], mass=[0, 0], rod=[1, 1], parent=[0, 1]), np.linspace(-np.pi, np.pi, 300)
axes = [dict(vary="theta", arm=arm, start=angle[0], stop=angle[-1], count=300) for arm in (1, 2)]
job = rods.ensemble(grid=axes, duration=30, observables=["first_flip"], job=True)
job.save("figure.png")
turned, bound = job.result().first_flip_arm.reshape(300, 300) > 0, 3 * np.cos(angle) + np.cos(angle)[:, None]
print("none turns over within the curve:", not turned[bound > 2.001].any(), "beyond it most do:", turned[bound < 1.5].mean() > 0.5)
