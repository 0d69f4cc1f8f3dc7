"""A motion as a differentiable service: apply, jacobian, jvp and vjp of the angles by two lengths and a start."""
import numpy as np
from pendulumd import Pendulum
by = [dict(vary="length", arm=1), dict(vary="length", arm=2), dict(vary="phi", arm=1)]
def ask(x, **fields): return Pendulum(length=list(x[:2]), mass=[1, 1], parent=[0, 1]).run("0:3/31", phi=[x[2], -1], output=["phi"], **fields)
def apply(x): return ask(x).phi
def jacobian(x): return ask(x, derivatives=by)["derivatives_phi"]
def jvp(x, tangent): return jacobian(x) @ tangent
def vjp(x, cotangent): return np.tensordot(cotangent, jacobian(x), 2)
x, step, weight = np.array([1, 0.8, -0.5]), np.array([0.3, -0.2, 0.5]), np.cos(np.arange(62)).reshape(31, 2)
pushed, pulled = jvp(x, step), vjp(x, weight)
print("forwards and backwards agree:", np.isclose((weight * pushed).sum(), pulled @ step, rtol=1e-12))
print("as differences say:", np.allclose(pushed, (apply(x + 1e-6 * step) - apply(x - 1e-6 * step)) / 2e-6, atol=1e-7))
seen, x = apply(x), x + [0.05, -0.04, 0.06]
for _ in range(6): x = x - np.linalg.lstsq(jacobian(x).reshape(62, 3), (apply(x) - seen).ravel(), rcond=None)[0]
print("the descent finds what made the angles:", np.allclose(x, [1, 0.8, -0.5], atol=1e-9))
