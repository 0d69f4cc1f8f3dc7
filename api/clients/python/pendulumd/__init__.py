"""Planar pendulum trees, computed by a pendulumd server or by the engine in this process, as NumPy arrays.

    from pendulumd import Pendulum
    pendulum = Pendulum([1, 1], [1, 1], [0, 1])
    motion = pendulum.run("0:5:0.01", theta=[2, 2.5])
    print(motion.phi[-1], motion.stats["horizon"])

The modules in order: pendulum (what is asked), operations (its methods), client and local (who answers), aio (coroutines),
arrays (answers), measured (files of measurements), pictures (plots), dataset (training data), envs (environments of reinforcement learning).
"""
from .arrays import Result
from .client import Client, Job, NoServer, Problem
from .local import Local
from .pendulum import Pendulum

__all__ = ["Client", "Job", "Local", "NoServer", "Pendulum", "Problem", "Result"]
