"""The largest Lyapunov exponent of a double pendulum against its energy: 60 energies, 500 s each."""
from pendulumd import Pendulum
energies = [dict(vary="energy", start=-29, stop=29, count=60)]
found = Pendulum(length=[1, 1], mass=[1, 1], parent=[0, 1]).ensemble(grid=energies, initial=dict(theta=[0, 0], thetad=[1, 1]), duration=500, observables=["lyapunov"])
print("calm below", "-20 J:", (found.lyapunov[:10] < 0.1).all(), "chaotic above 0 J:", (found.lyapunov[30:] > 0.1).all())
