"""The largest Lyapunov exponent of a double pendulum over its energy, 60 energies of 500 s."""
import numpy as np
from pendulumd import Pendulum
double = Pendulum(length=[1, 1], mass=[1, 1], parent=[0, 1])
angle = np.arccos(-np.linspace(-29, 29, 60) / (3 * 9.81))  # both arms at one angle, at rest: E = -3 g cos(angle)
found = double.ensemble(states=[{"theta": [a, a]} for a in angle], duration=500, observables=["lyapunov"])
print("calm below", "-20 J:", (found.lyapunov[:10] < 0.1).all(), "chaotic above 0 J:", (found.lyapunov[30:] > 0.1).all())
