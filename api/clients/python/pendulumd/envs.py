"""Environments of reinforcement learning by Gymnasium's interface: many pendulums per step, by the engine in this process.

    from pendulumd.envs import CartPole
    envs = CartPole(4096)
    observations, _ = envs.reset(seed=1)
    observations, rewards, terminated, truncated, _ = envs.step(envs.action_space.sample())

Leaves to others: the steps (local.Steps). Without Gymnasium the environments work, with spaces that are described and sampled alone.
Invariant: CartPole, Acrobot and Pendulum have the equations, rewards and ends of Gymnasium's classic control; the motion of a step is
integrated to `rtol` instead of Euler's or Runge's single step. An environment that has ended is reset by its next step.
"""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Callable, ClassVar, Optional, Union

import numpy as np

from .local import Local, Steps
from .pendulum import Pendulum as Tree

try:
    import gymnasium  # type: ignore[import]
    from gymnasium.spaces import Box, Discrete  # type: ignore[import]
    from gymnasium.vector.utils import batch_space  # type: ignore[import]

    _Vector: Any = gymnasium.vector.VectorEnv
    _Single: Any = gymnasium.Env
    AUTORESET: Any = gymnasium.vector.AutoresetMode.NEXT_STEP
except ImportError:
    _Vector = _Single = object
    AUTORESET = "NextStep"

    class Box:  # type: ignore[no-redef]
        """Arrays within bounds."""

        def __init__(self, low: Any, high: Any, shape: tuple[int, ...] = (), dtype: Any = np.float32) -> None:
            self.low, self.high, self.dtype = np.broadcast_to(low, shape), np.broadcast_to(high, shape), np.dtype(dtype)
            self.shape, self.random = shape, np.random.default_rng()

        def sample(self) -> Any:
            return self.random.uniform(np.maximum(self.low, -1e9), np.minimum(self.high, 1e9)).astype(self.dtype)

    class Discrete:  # type: ignore[no-redef]
        """Whole numbers from 0 to n - 1."""

        def __init__(self, n: int, shape: tuple[int, ...] = ()) -> None:
            self.n, self.shape, self.dtype, self.random = n, shape, np.dtype(np.int64), np.random.default_rng()

        def sample(self) -> Any:
            return self.random.integers(self.n, size=self.shape)

    def batch_space(space: Any, n: int = 1) -> Any:
        """The space of n environments."""
        return Discrete(space.n, (n,)) if isinstance(space, Discrete) else Box(np.broadcast_to(space.low, (n, *space.shape)), space.high, (n, *space.shape), space.dtype)


def _driven(pendulum: dict[str, Any]) -> tuple[dict[str, Any], dict[str, float]]:
    """A pendulum with a torque in every joint and a force on a cart, given by its arms and its own constants by name."""
    tree = Local().call("trees", {"pendulum": pendulum})
    made = {name: tree[name] for name in ("arms", "gravity", "drag_per_mass", "control", "pivot") if name in tree}
    cart = made.get("pivot", {}).get("cart")
    inputs = [(arm["name"], arm, "torque") for arm in made["arms"]] + ([("cart", cart, "force")] if cart else [])
    own = {}
    for name, at, field in inputs:
        given = at.get(field, 0.0)
        own[name] = given.get("constant", 0.0) if isinstance(given, dict) else given
        at[field] = given | {"constant": 1.0} if isinstance(given, dict) else 1.0  # in its place comes what is held
    return made, own


class VectorEnv(_Vector):  # type: ignore[misc]
    """`num_envs` copies of a pendulum; a subclass defines observations, rewards and the end of an episode.

    state    (num_envs, 2 n + 1): theta of every arm, rad, the rates, rad/s, place, m, and speed, m/s, of a cart, and the time, s
    threads  that compute side by side
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": ["rgb_array"], "render_fps": 50, "autoreset_mode": AUTORESET}
    pendulum: dict[str, Any] = {}
    actuators: Sequence[Union[int, str]] = ()
    dt = 0.02  # s, of a step
    max_episode_steps: Optional[int] = None

    def __init__(self, num_envs: int = 1, *, dt: Optional[float] = None, rtol: float = 1e-9, threads: int = 1, max_episode_steps: Optional[int] = None, render_mode: Optional[str] = None) -> None:
        self.num_envs, self.dt, self.render_mode = num_envs, dt or self.dt, render_mode
        self.max_episode_steps = max_episode_steps or self.max_episode_steps
        tree, own = _driven(self.pendulum)
        names = list(own)
        self._steps = Steps(len(names), {"pendulum": tree, "duration": self.dt, "rtol": rtol, "states": [{}]}, threads)
        self._driven = [names.index(one) if isinstance(one, str) else one - 1 for one in self.actuators]
        self.tree = Tree(client="local", **self.pendulum)
        self.state = np.zeros((num_envs, 2 * len(names) + 1))
        self._inputs = np.tile(np.array(list(own.values())), (num_envs, 1))
        self._age = np.zeros(num_envs, int)
        self._done = np.zeros(num_envs, bool)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._rng = np.random.default_rng()

    # defined by a subclass

    single_observation_space: Any = None
    single_action_space: Any = None

    def start(self, rng: np.random.Generator, count: int) -> Any:
        """Returns (count, 2 n) states at the start of episodes, time 0."""
        return np.zeros((count, self.state.shape[1] - 1))

    def inputs(self, actions: Any) -> Any:
        """Returns (num_envs, actuators) torques, N m, and forces, N, for actions."""
        return actions

    def observe(self, state: Any) -> Any:
        return state

    def reward(self, before: Any, inputs: Any, after: Any) -> Any:
        return np.ones(len(after))

    def ended(self, state: Any) -> Any:
        return np.zeros(len(state), bool)

    def limit(self, state: Any) -> None:
        """Changes states in place after a step, such as bounds of rates."""

    # Gymnasium's interface

    def reset(self, *, seed: Optional[int] = None, options: Optional[dict[str, Any]] = None) -> tuple[Any, dict[str, Any]]:
        if seed is not None:
            self._rng = np.random.default_rng(seed)
        self.state[:, :-1], self.state[:, -1] = self.start(self._rng, self.num_envs), 0
        self._age[:], self._done[:] = 0, False
        return self._observation(), {}

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        fresh, state = self._done, self.state
        inputs = np.reshape(self.inputs(np.asarray(actions)), (self.num_envs, len(self._driven)))
        before = state.copy()
        failed = self.advance(inputs)
        self.limit(state)
        reward, terminated = self.reward(before, inputs, state), self.ended(state)
        self._age += 1
        if failed:
            wrong = ~np.isfinite(state).all(axis=1)
            state[wrong], reward[wrong] = before[wrong], 0
            terminated = terminated | wrong
        if fresh.any():
            state[fresh, :-1], state[fresh, -1] = self.start(self._rng, int(fresh.sum())), 0
            self._age[fresh], reward[fresh] = 0, 0
            terminated = terminated & ~fresh
        truncated = self._age >= self.max_episode_steps if self.max_episode_steps else np.zeros(self.num_envs, bool)
        self._done = terminated | truncated
        return self._observation(), reward, terminated, truncated, {}

    def advance(self, inputs: Any) -> int:
        """Moves `state` by a step with these torques and forces, without limits, rewards and ends; returns the number of failures (states of NaN)."""
        self._inputs[:, self._driven] = inputs
        return self._steps(self.state, self._inputs)

    def _observation(self) -> Any:
        return np.asarray(self.observe(self.state), self.single_observation_space.dtype)

    def render(self) -> Any:
        """Draws the first pendulum, (300, 300, 3) bytes, by matplotlib."""
        from .pictures import frame
        n = self.state.shape[1] // 2
        arms = n - ("cart" in self.tree.fields.get("pivot", {}))
        return frame(self.tree, self.state[0, :arms] - np.pi / 2, self.state[0, 2 * arms] if arms < n else 0.0)

    def close(self, **_: Any) -> None:
        self._steps.close()


class Env(_Single):  # type: ignore[misc]
    """One environment of a vector, which does not reset itself: `Env(CartPole)`."""

    metadata: ClassVar[dict[str, Any]] = {"render_modes": ["rgb_array"], "render_fps": 50}

    def __init__(self, kind: Callable[..., VectorEnv], render_mode: Optional[str] = None, **fields: Any) -> None:
        self.vector, self.render_mode = kind(1, render_mode=render_mode, **fields), render_mode
        self.observation_space, self.action_space = self.vector.single_observation_space, self.vector.single_action_space

    def reset(self, *, seed: Optional[int] = None, options: Optional[dict[str, Any]] = None) -> tuple[Any, dict[str, Any]]:
        if _Single is not object:
            super().reset(seed=seed)
        observations, info = self.vector.reset(seed=seed, options=options)
        return observations[0], info

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        self.vector._done[:] = False
        observations, rewards, terminated, truncated, info = self.vector.step(np.asarray(action)[None])
        return observations[0], float(rewards[0]), bool(terminated[0]), bool(truncated[0]), info

    def render(self) -> Any:
        return self.vector.render()

    def close(self) -> None:
        self.vector.close()


def _box(*high: float) -> Any:
    return Box(-np.array(high, np.float32), np.array(high, np.float32), (len(high),), np.float32)


_INF = float("inf")


class CartPole(VectorEnv):
    """A rod of 1 m and 0.1 kg on a cart of 1 kg that is pushed by 10 N to the left (0) or right (1). Observed: x, its speed, the angle from upright to the right, its rate."""

    pendulum = {"length": [1.0], "mass": [0.0], "parent": [0], "rod": [0.1], "gravity": 9.8, "pivot": {"cart": {"mass": 1.0}}}
    actuators = ("cart",)
    max_episode_steps = 500
    single_observation_space = _box(4.8, _INF, 0.41887903, _INF)
    single_action_space = Discrete(2)

    def start(self, rng: np.random.Generator, count: int) -> Any:
        x, v, angle, rate = rng.uniform(-0.05, 0.05, (4, count))
        return np.column_stack([np.pi - angle, -rate, x, v])

    def inputs(self, actions: Any) -> Any:
        return 20.0 * actions - 10.0

    def observe(self, state: Any) -> Any:
        return np.column_stack([state[:, 2], state[:, 3], np.pi - state[:, 0], -state[:, 1]])

    def ended(self, state: Any) -> Any:
        return (np.abs(state[:, 2]) > 2.4) | (np.abs(np.pi - state[:, 0]) > 12 * 2 * np.pi / 360)


class Pendulum(VectorEnv):
    """A rod of 1 m and 1 kg with a motor of at most 2 N m at the pivot, to be held upright. Observed: cosine, sine and rate of the angle from upright."""

    pendulum = {"length": [1.0], "mass": [0.0], "parent": [0], "rod": [1.0], "gravity": 10.0}
    actuators = (1,)
    dt = 0.05
    max_episode_steps = 200
    single_observation_space = _box(1, 1, 8)
    single_action_space = _box(2)

    def start(self, rng: np.random.Generator, count: int) -> Any:
        return np.column_stack([rng.uniform(-np.pi, np.pi, count) + np.pi, rng.uniform(-1, 1, count)])

    def inputs(self, actions: Any) -> Any:
        return np.clip(actions, -2, 2)

    def limit(self, state: Any) -> None:
        np.clip(state[:, 1], -8, 8, out=state[:, 1])

    def observe(self, state: Any) -> Any:
        return np.column_stack([-np.cos(state[:, 0]), -np.sin(state[:, 0]), state[:, 1]])

    def reward(self, before: Any, inputs: Any, after: Any) -> Any:
        angle = before[:, 0] % (2 * np.pi) - np.pi
        return -(angle**2 + 0.1 * before[:, 1] ** 2 + 0.001 * inputs[:, 0] ** 2)


class Acrobot(VectorEnv):
    """Two bodies of 1 kg, 1 m and 1 kg m^2 with a motor of -1 (0), 0 (1) or 1 N m (2) in the second joint; the goal is a tip 1 m above the pivot. Observed: cosine and sine of the first angle and of the second one against the first, their rates."""

    pendulum = {"length": [1.0, 1.0], "mass": [0.0, 0.0], "parent": [0, 1], "gravity": 9.8, "body": [{"mass": 1.0, "center": 0.5, "inertia": 1.0}] * 2}
    actuators = (2,)
    dt = 0.2
    max_episode_steps = 500
    single_observation_space = _box(1, 1, 1, 1, 4 * np.pi, 9 * np.pi)
    single_action_space = Discrete(3)

    def start(self, rng: np.random.Generator, count: int) -> Any:
        first, second, rate, other = rng.uniform(-0.1, 0.1, (4, count))
        return np.column_stack([first, first + second, rate, rate + other])

    def inputs(self, actions: Any) -> Any:
        return actions - 1.0

    def limit(self, state: Any) -> None:
        joint = np.clip(state[:, 3] - state[:, 2], -9 * np.pi, 9 * np.pi)
        np.clip(state[:, 2], -4 * np.pi, 4 * np.pi, out=state[:, 2])
        state[:, 3] = state[:, 2] + joint

    def observe(self, state: Any) -> Any:
        joint = state[:, 1] - state[:, 0]
        return np.column_stack([np.cos(state[:, 0]), np.sin(state[:, 0]), np.cos(joint), np.sin(joint), state[:, 2], state[:, 3] - state[:, 2]])

    def reward(self, before: Any, inputs: Any, after: Any) -> Any:
        return np.where(self.ended(after), 0.0, -1.0)

    def ended(self, state: Any) -> Any:
        return -np.cos(state[:, 0]) - np.cos(state[:, 1]) > 1


class DoubleCartPole(VectorEnv):
    """Two rods of 0.6 m and 0.1 kg, one on the other, to be kept upright on a cart of 1 kg that is pushed by at most 10 N. Observed: x, sines and cosines from upright, the speed, the rates."""

    pendulum = {"length": [0.6, 0.6], "mass": [0.0, 0.0], "parent": [0, 1], "rod": [0.1, 0.1], "gravity": 9.81, "pivot": {"cart": {"mass": 1.0}}}
    actuators = ("cart",)
    max_episode_steps = 1000
    single_observation_space = _box(*[_INF] * 8)
    single_action_space = _box(1)

    def start(self, rng: np.random.Generator, count: int) -> Any:
        return rng.uniform(-0.05, 0.05, (count, 6)) + np.array([np.pi, np.pi, 0, 0, 0, 0])

    def inputs(self, actions: Any) -> Any:
        return 10 * np.clip(actions, -1, 1)

    def observe(self, state: Any) -> Any:
        angle = np.pi - state[:, :2]
        return np.column_stack([state[:, 4], np.sin(angle), np.cos(angle), state[:, 5], -state[:, 2:4]])

    def reward(self, before: Any, inputs: Any, after: Any) -> Any:
        return 1.0 - 0.01 * after[:, 4] ** 2 - 0.001 * (after[:, 2:4] ** 2).sum(axis=1)

    def ended(self, state: Any) -> Any:
        return (np.abs(state[:, 4]) > 2.4) | (-0.6 * np.cos(state[:, :2]).sum(axis=1) < 0.9)


class TreeEnv(VectorEnv):
    """Any pendulum: `TreeEnv(64, pendulum=..., actuators=[2, "cart"], reward=lambda before, inputs, after: ...)`. Actions are torques, N m, and forces, N, up to `most`."""

    def __init__(self, num_envs: int = 1, *, pendulum: Union[Tree, dict[str, Any]], actuators: Sequence[Union[int, str]], most: Any = 1.0,
                 reward: Optional[Callable[[Any, Any, Any], Any]] = None, ended: Optional[Callable[[Any], Any]] = None,
                 start: Optional[Callable[[np.random.Generator, int], Any]] = None, **fields: Any) -> None:
        self.pendulum, self.actuators = pendulum.fields if isinstance(pendulum, Tree) else pendulum, actuators
        for name, given in (("reward", reward), ("ended", ended), ("start", start)):
            if given:
                setattr(self, name, given)
        size = 2 * len(_driven(self.pendulum)[1]) + 1
        self.single_observation_space = Box(-_INF, _INF, (size,), np.float64)
        self.single_action_space = _box(*np.broadcast_to(most, len(actuators)))
        super().__init__(num_envs, **fields)


ENVIRONMENTS = {"CartPole": CartPole, "Pendulum": Pendulum, "Acrobot": Acrobot, "DoubleCartPole": DoubleCartPole}


def register() -> None:
    """Registers the environments with Gymnasium: `gymnasium.make("pendulumd/CartPole-v0")`, `gymnasium.make_vec(...)`."""
    for name, kind in ENVIRONMENTS.items():
        gymnasium.register(f"pendulumd/{name}-v0", entry_point=lambda kind=kind, **fields: Env(kind, **fields), vector_entry_point=kind)
