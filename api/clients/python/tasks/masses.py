"""The largest force in each arm over 50 x 50 ratios of masses and lengths."""
from pendulumd import Pendulum
double = Pendulum(length=[1, 1], mass=[1, 1], parent=[0, 1])
axes = [dict(vary="mass", arm=2, start=0.1, stop=10, count=50, scale="log"), dict(vary="length", arm=2, start=0.2, stop=5, count=50, scale="log")]
found = double.ensemble(grid=axes, initial=dict(theta=[1.5, 1.5]), duration=10, observables=["lambda_min", "parameters"])
pull = -found.lambda_min_value.reshape(50, 50, 2)
print("the heavier the second mass, the harder it pulls:", (pull[:, -1, 0] > 5 * pull[:, 0, 0]).all())
