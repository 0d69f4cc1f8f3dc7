"""Poincare sections of a double pendulum at one energy: 40 starts, passages of the first arm through the vertical, one request."""
import numpy as np
from pendulumd import Pendulum
energy, starts = -15, [dict(vary="theta", arm=2, start=-1.1, stop=1.1, count=40)]
found = Pendulum(length=[1, 1], mass=[1, 1], parent=[0, 1]).ensemble(energy=energy, grid=starts, initial=dict(theta=[0, 0], thetad=[1, 0]), duration=200,
    events=[dict(of="theta", arm=1, value=0, direction="up")], rows="events")
theta, rate = found.phi[:, 1] + np.pi / 2, found.phid
kinetic = rate[:, 0] ** 2 + rate[:, 1] ** 2 / 2 + rate[:, 0] * rate[:, 1] * np.cos(theta)
print(len(set(found.member)), "orbits,", len(theta) > 2000, "many points, all at the energy:", abs(kinetic - 9.81 * (2 + np.cos(theta)) - energy).max() < 1e-9)
