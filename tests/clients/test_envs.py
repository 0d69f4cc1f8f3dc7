"""Environments of the Python client: Gymnasium's interface, determinism, any tree.

Leaves to others: the equations (api/guide/learning.md), the steps (tests/api/op/ensemble/test_held.c), the rest of the client (test_python.py).
"""
import os
import subprocess
import sys
import warnings

import numpy as np

from clients import TOP
from rule import check, skip


def played(kind, threads):
    """All that 70 steps of 50 environments return, and how many ended."""
    env, rng, ends = kind(50, threads=threads, max_episode_steps=30), np.random.default_rng(1), 0
    seen = [env.reset(seed=3)[0]]
    for _ in range(70):
        seen += env.step(rng.integers(space.n, size=50) if hasattr(space := env.single_action_space, "n") else rng.uniform(-1, 1, env.action_space.shape))[:4]
        ends += (seen[-1] | seen[-2]).sum()
    env.close()
    return seen, ends >= 100 and seen[0].shape == env.observation_space.shape and seen[0].dtype == env.observation_space.dtype and seen[2].shape == (50,)


def test_interface(envs):
    for name, kind in envs.ENVIRONMENTS.items():
        runs = [played(kind, threads) for threads in (1, 1, 3)]
        check(f"{name}: the same seed and actions give the same bits, with three threads too", all(np.array_equal(a, b) for seen, _ in runs[1:] for a, b in zip(runs[0][0], seen)))
        check(f"{name}: observations have the space's shape and type, and episodes end", all(good for _, good in runs))
    (env := envs.CartPole(2, max_episode_steps=5)).reset(seed=0)
    came = [env.step(np.array([0, 1])) for _ in range(7)]
    check("an environment that has ended is reset by the next step, whose reward is 0",
          [bool(one[3][0]) for one in came] == [False] * 4 + [True] + [False] * 2 and came[5][1][0] == 0 and np.abs(came[5][0]).max() <= 0.05 and came[6][1][0] == 1)
    check("a single environment", (one := envs.Env(envs.Acrobot)).reset(seed=4)[0].shape == (6,) and one.step(1)[1:] == (-1.0, False, False, {}))


def test_any_tree(envs):
    from pendulumd import Pendulum, Problem
    tree = dict(length=[1, 0.5, 0.5], mass=[1, 1, 0.5], parent=[0, 1, 1], damping=[0.1, 0, 0])
    env = envs.TreeEnv(4, pendulum=Pendulum(**tree, torque=[0, 0.2, 0]), actuators=[1, 3], dt=0.1, reward=lambda before, inputs, after: -(inputs**2).sum(axis=1))
    env.reset(seed=1)
    observed, rewards, *_ = env.step(np.array([[0, 0], [1, 0], [0, 1], [0, 0]]))
    same = Pendulum(**tree, torque=[1, 0.2, 0], client="local").run([0, 0.1], theta=[0, 0, 0])
    check("any tree takes held torques, beside its own constants", np.allclose(observed[1, :3], same.phi[-1] + np.pi / 2, atol=1e-9)
          and np.array_equal(observed[0], observed[3]) and list(rewards) == [0, -1, -1, 0])
    one = dict(length=[1], mass=[1], parent=[0])
    (wrong := envs.TreeEnv(2, pendulum=one, actuators=[1], start=lambda rng, count: np.array([[0.1, 0.0], [0.1, 1e300]])[:count])).reset()
    observed, rewards, terminated, *_ = wrong.step(np.zeros((2, 1)))
    check("a motion that fails ends its episode and keeps its numbers finite", list(terminated) == [False, True] and np.isfinite(observed).all() and rewards[1] == 0)
    try:
        told = envs.TreeEnv(1, pendulum=one | {"mass": [-1]}, actuators=[1])
    except Problem as error:
        told = error
    check("a wrong pendulum is refused with the reasons", "mass" in str(told), told)


def test_gymnasium(envs):
    try:
        import gymnasium
        from gymnasium.utils.env_checker import check_env
    except ImportError:
        skip("Gymnasium's check_env", "gymnasium is not installed")
        return
    envs.register()
    for name, kind in envs.ENVIRONMENTS.items():
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            check_env(envs.Env(kind), skip_render_check=True)
        wrong = [str(one.message) for one in told if not any(word in str(one.message) for word in ("render", "infinity", "recommend"))]
        check(f"{name}: check_env finds nothing", not wrong, "\n".join(wrong))
        first = (vector := gymnasium.make_vec(f"pendulumd/{name}-v0", num_envs=3)).reset(seed=1)[0]
        check(f"{name}: make and make_vec", vector.step(vector.action_space.sample())[1].shape == (3,)
              and gymnasium.make(f"pendulumd/{name}-v0").reset(seed=1)[0].shape == first[0].shape)


def test_envs(server, home):
    library = f"{os.environ['PENDULUM_BUILD']}/libpendulum.so"
    made = subprocess.run(["make", "-s", os.path.relpath(library, TOP)], cwd=TOP, capture_output=True, text=True)
    check("libpendulum.so is built", made.returncode == 0, made.stderr[-2000:])
    os.environ["PENDULUM_LIBRARY"] = library
    sys.path.insert(0, str(TOP / "api/clients/python"))
    from pendulumd import envs
    test_interface(envs), test_any_tree(envs), test_gymnasium(envs)
    sys.path.pop(0)
