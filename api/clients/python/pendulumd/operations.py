"""The operations of a pendulumd server as methods with their parameters. Written by operations.py from the OpenAPI document.

Leaves to others: asking (pendulum.py). Invariant: a field that is not named here goes to the server unchanged.
"""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, Optional, Union

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

ROUTES = {"run": "trajectories", "forces": "forces", "tree": "trees", "modes": "modes", "ensemble": "ensembles", "lyapunov": "lyapunov", "section": "sections", "response": "response", "controller": "controllers", "orbits": "orbits", "fits": "fits", "tables": "tables", "equations": "equations"}


class Operations:
    """Methods of a Pendulum."""

    def _method(self, name: str, given: dict[str, Any]) -> Any:
        raise NotImplementedError

    def run(
        self,
        times: Any,
        *,
        theta: Optional[ArrayLike] = None,
        thetad: Optional[ArrayLike] = None,
        phi: Optional[ArrayLike] = None,
        phid: Optional[ArrayLike] = None,
        unit: Optional[Literal["rad", "deg"]] = None,
        mode: Optional[int] = None,
        amplitude: Optional[float] = None,
        initial: Optional[Any] = None,
        method: Optional[Literal["taylor", "ode23", "rkf45", "rk8pd", "msadams", "symplectic", "linear", "radau"]] = None,
        rtol: Optional[float] = None,
        atol: Optional[float] = None,
        step: Optional[float] = None,
        precision: Optional[Literal["double", "extended"]] = None,
        output: Optional[Sequence[Literal["phi", "phid", "phidd", "theta", "thetad", "z", "zd", "lambda", "energy", "joint_force", "tip_force", "exchange", "cart", "control"]]] = None,
        number: Optional[Literal["float64", "float32"]] = None,
        digits: Optional[int] = None,
        trust: Optional[Any] = None,
        accuracy: Optional[float] = None,
        derivatives: Optional[Sequence[Mapping[str, Any]]] = None,
        events: Optional[Sequence[Mapping[str, Any]]] = None,
        rows: Optional[Literal["instants", "events"]] = None,
        job: Union[bool, str] = False,
        title: Optional[str] = None,
        save: Any = None,
        **fields: Any,
    ) -> Any:
        """Integrate the motion of a pendulum.

        times: "start:stop:step", "start:stop/count", an array of instants, or a dict of the interface.
        theta: Angles from hanging, of the start.
        thetad: Angular velocities of the start.
        phi: Angles from the positive real axis, instead of theta.
        phid: Angular velocities, instead of thetad.
        unit: Unit of the start's angles.
        mode: Start in this mode, with `amplitude`, instead of angles.
        amplitude: Amplitude of the mode of the start.
        initial: The state at the first instant.
        method: How the motion is integrated.
        rtol: Relative tolerance.
        atol: Absolute tolerance, rad and rad/s: an error is allowed if either tolerance allows it.
        step: Length of every step, s; only for the method `symplectic`.
        precision: Arithmetic of the integration.
        output: The output besides `t`.
        number: The type of the numbers of `application/octet-stream`, NPZ and Parquet: doubles, or doubles rounded to floats of 4 bytes.
        digits: Rounds the numbers of the answer to at most this many significant digits; 6 is enough to draw.
        trust: Whether to determine how long the answer is accurate.
        accuracy: The error bound of `horizon` in the stats.
        derivatives: The parameters with respect to which the answer's quantities are differentiated.
        events: Conditions whose passages are reported: the instants at which a quantity reaches a value.
        rows: The meaning of a row of the answer: the instants of `times`, or the passages of `events` between the first and the last of these, in the columns
            `t`, `event`, `direction` (1 up, -1 down), `phi` and `phid`, and `cart` where there is one; without `output`, `trust` and `derivatives`.
        job: True, or a key of your own: a Job is returned at once.
        title: A name of the job in lists.
        save: A file's path, whose suffix is the format; the path is returned.
        """
        given = dict(locals())
        return self._method("run", given)

    def forces(
        self,
        *,
        theta: Optional[ArrayLike] = None,
        thetad: Optional[ArrayLike] = None,
        phi: Optional[ArrayLike] = None,
        phid: Optional[ArrayLike] = None,
        unit: Optional[Literal["rad", "deg"]] = None,
        mode: Optional[int] = None,
        amplitude: Optional[float] = None,
        initial: Optional[Any] = None,
        states: Optional[Sequence[Any]] = None,
        time: Optional[float] = None,
        digits: Optional[int] = None,
        derivatives: Optional[Sequence[Mapping[str, Any]]] = None,
        job: Union[bool, str] = False,
        title: Optional[str] = None,
        save: Any = None,
        **fields: Any,
    ) -> Any:
        """Accelerations and forces of given states.

        theta: Angles from hanging, of the start.
        thetad: Angular velocities of the start.
        phi: Angles from the positive real axis, instead of theta.
        phid: Angular velocities, instead of thetad.
        unit: Unit of the start's angles.
        mode: Start in this mode, with `amplitude`, instead of angles.
        amplitude: Amplitude of the mode of the start.
        initial: One state.
        states: Many states, at most `max-samples`.
        time: The time at which drives are taken, s.
        digits: Rounds the numbers of the answer to at most this many significant digits; 6 is enough to draw.
        derivatives: The parameters with respect to which the answer's quantities are differentiated.
        job: True, or a key of your own: a Job is returned at once.
        title: A name of the job in lists.
        save: A file's path, whose suffix is the format; the path is returned.
        """
        given = dict(locals())
        return self._method("forces", given)

    def tree(
        self,
        *,
        job: Union[bool, str] = False,
        title: Optional[str] = None,
        save: Any = None,
        **fields: Any,
    ) -> Any:
        """Check a pendulum and describe its shape.

        job: True, or a key of your own: a Job is returned at once.
        title: A name of the job in lists.
        save: A file's path, whose suffix is the format; the path is returned.
        """
        given = dict(locals())
        return self._method("tree", given)

    def modes(
        self,
        *,
        about: Optional[Sequence[Literal["down", "up"]]] = None,
        select: Optional[Any] = None,
        vectors: Optional[bool] = None,
        normalize: Optional[Literal["first", "mass", "max"]] = None,
        include: Optional[Sequence[Literal["A", "M", "S", "B", "C", "K"]]] = None,
        theta: Optional[ArrayLike] = None,
        thetad: Optional[ArrayLike] = None,
        phi: Optional[ArrayLike] = None,
        phid: Optional[ArrayLike] = None,
        unit: Optional[Literal["rad", "deg"]] = None,
        mode: Optional[int] = None,
        amplitude: Optional[float] = None,
        initial: Optional[Any] = None,
        derivatives: Optional[Sequence[Mapping[str, Any]]] = None,
        digits: Optional[int] = None,
        job: Union[bool, str] = False,
        title: Optional[str] = None,
        save: Any = None,
        **fields: Any,
    ) -> Any:
        """Frequencies and shapes of small oscillations.

        about: The equilibrium, one word per arm, `down` for one that hangs.
        select: The modes to return.
        vectors: Whether the shapes of the modes are returned too.
        normalize: How the shapes are scaled: `first` makes the first entry that is not zero 1, as the paper prints them; `mass` makes v^T M v = 1, M being
            the mass matrix at the equilibrium; `max` makes the entry of largest magnitude 1.
        include: Matrices to return, of M x'' + C x' + K x = B u at the equilibrium: x are the angles from it, u the torques in the joints.
        theta: Angles from hanging, of the start.
        thetad: Angular velocities of the start.
        phi: Angles from the positive real axis, instead of theta.
        phid: Angular velocities, instead of thetad.
        unit: Unit of the start's angles.
        mode: Start in this mode, with `amplitude`, instead of angles.
        amplitude: Amplitude of the mode of the start.
        initial: A start, to be decomposed into the modes.
        derivatives: The lengths, masses or gravity by which `omega` is differentiated, for an ideal pendulum whose arms hang, without `select`.
        digits: Rounds the numbers of the answer to at most this many significant digits; 6 is enough to draw.
        job: True, or a key of your own: a Job is returned at once.
        title: A name of the job in lists.
        save: A file's path, whose suffix is the format; the path is returned.
        """
        given = dict(locals())
        return self._method("modes", given)

    def ensemble(
        self,
        *,
        states: Optional[Sequence[Any]] = None,
        members: Optional[Sequence[Mapping[str, Any]]] = None,
        grid: Optional[Sequence[Mapping[str, Any]]] = None,
        random: Optional[Mapping[str, Any]] = None,
        theta: Optional[ArrayLike] = None,
        thetad: Optional[ArrayLike] = None,
        phi: Optional[ArrayLike] = None,
        phid: Optional[ArrayLike] = None,
        unit: Optional[Literal["rad", "deg"]] = None,
        mode: Optional[int] = None,
        amplitude: Optional[float] = None,
        initial: Optional[Any] = None,
        energy: Optional[float] = None,
        duration: Optional[float] = None,
        time: Optional[float] = None,
        times: Optional[Any] = None,
        observables: Optional[Sequence[Literal["start", "parameters", "final", "first_flip", "flip_time", "flips", "lambda_max", "lambda_min", "sign_change", "energy_drift", "lyapunov", "horizon", "cart", "settled", "trajectory"]]] = None,
        output: Optional[Sequence[Literal["phi", "phid", "theta", "thetad", "lambda", "cart", "phidd", "z", "zd", "energy"]]] = None,
        within: Optional[float] = None,
        method: Optional[Literal["taylor"]] = None,
        rtol: Optional[float] = None,
        atol: Optional[float] = None,
        accuracy: Optional[float] = None,
        events: Optional[Sequence[Mapping[str, Any]]] = None,
        rows: Optional[Literal["members", "events"]] = None,
        derivatives: Optional[Sequence[Mapping[str, Any]]] = None,
        picture: Optional[Mapping[str, Any]] = None,
        columns: Optional[Sequence[str]] = None,
        number: Optional[Literal["float64", "float32"]] = None,
        digits: Optional[int] = None,
        job: Union[bool, str] = False,
        title: Optional[str] = None,
        save: Any = None,
        **fields: Any,
    ) -> Any:
        """Many trajectories of one pendulum.

        states: The starts of the members.
        members: The members one by one, each with its start and the numbers in which its pendulum differs from `pendulum`.
        grid: Axes; the members are their product.
        random: Random members.
        theta: Angles from hanging, of the start.
        thetad: Angular velocities of the start.
        phi: Angles from the positive real axis, instead of theta.
        phid: Angular velocities, instead of thetad.
        unit: Unit of the start's angles.
        mode: Start in this mode, with `amplitude`, instead of angles.
        amplitude: Amplitude of the mode of the start.
        initial: With `members`, `grid` and `random`, the start values of quantities that do not vary.
        energy: Energy at which all members start, J: kinetic plus potential energy as in trajectories, measured from the pivot.
        duration: Duration of the members, s.
        time: When members begin, s, in the time of the pendulum's drives.
        times: The instants of the trajectories.
        observables: The observables.
        output: The output of trajectories, as `output` of `POST /v1/trajectories`, of each member's own pendulum; `cart` is the position `x` and the speed
            `v` of a cart, m and m/s.
        within: The bound of the observable `settled`, rad.
        method: The method is always `taylor`.
        rtol: Relative tolerance, as in `POST /v1/trajectories`.
        atol: Absolute tolerance, as in `POST /v1/trajectories`.
        accuracy: The error bound of `horizon` in the stats.
        events: Conditions on each member, as in `POST /v1/trajectories`.
        rows: The meaning of a row of the answer: the members, or the passages of `events`, member after member and each in the order of time, in the columns
            `member`, `status`, `t`, `event`, `direction` (1 up, -1 down), `phi` and `phid`, and `cart` where there is one; without `observables` and
            `derivatives`.
        derivatives: The parameters with respect to which each member's `final` state, as `final_phi` and `final_phid`, its `cart`, or each output of its
            `trajectory` is differentiated, as in `POST /v1/trajectories`.
        picture: What `image/png` shows: one number of a grid of two axes, in perceptually uniform shades from dark to light, for every kind of colour vision;
            white if it never happened, grey if a member failed.
        columns: The requested columns of the answer, by their names (`t`, `final`) or with their part (`final_phi`), as in CSV and `X-Columns`; by default
            all.
        number: The type of the numbers of `application/octet-stream`, NPZ and Parquet: doubles, or doubles rounded to floats of 4 bytes.
        digits: Rounds the numbers of the answer to at most this many significant digits; 6 is enough to draw.
        job: True, or a key of your own: a Job is returned at once.
        title: A name of the job in lists.
        save: A file's path, whose suffix is the format; the path is returned.
        """
        given = dict(locals())
        return self._method("ensemble", given)

    def lyapunov(
        self,
        *,
        theta: Optional[ArrayLike] = None,
        thetad: Optional[ArrayLike] = None,
        phi: Optional[ArrayLike] = None,
        phid: Optional[ArrayLike] = None,
        unit: Optional[Literal["rad", "deg"]] = None,
        mode: Optional[int] = None,
        amplitude: Optional[float] = None,
        initial: Optional[Any] = None,
        time: Optional[float] = None,
        duration: Optional[float] = None,
        transient: Optional[float] = None,
        samples: Optional[int] = None,
        count: Optional[Any] = None,
        digits: Optional[int] = None,
        job: Union[bool, str] = False,
        title: Optional[str] = None,
        save: Any = None,
        **fields: Any,
    ) -> Any:
        """Lyapunov exponents of a motion.

        theta: Angles from hanging, of the start.
        thetad: Angular velocities of the start.
        phi: Angles from the positive real axis, instead of theta.
        phid: Angular velocities, instead of thetad.
        unit: Unit of the start's angles.
        mode: Start in this mode, with `amplitude`, instead of angles.
        amplitude: Amplitude of the mode of the start.
        initial: The motion's start.
        time: The instant of `initial`, s, in the time of the pendulum's drives.
        duration: Duration of the motion after the transient, s.
        transient: Duration of the transient, s, in which the directions turn into those of growth; it is not counted.
        samples: Rows of the answer, at equal intervals; at most `max-samples`.
        count: The number of exponents, from the largest on, up to 2 n, or 2 n + 2 for a pendulum on a cart; or all of them.
        digits: Rounds the numbers of the answer to at most this many significant digits; 6 is enough to draw.
        job: True, or a key of your own: a Job is returned at once.
        title: A name of the job in lists.
        save: A file's path, whose suffix is the format; the path is returned.
        """
        given = dict(locals())
        return self._method("lyapunov", given)

    def section(
        self,
        *,
        theta: Optional[ArrayLike] = None,
        thetad: Optional[ArrayLike] = None,
        phi: Optional[ArrayLike] = None,
        phid: Optional[ArrayLike] = None,
        unit: Optional[Literal["rad", "deg"]] = None,
        mode: Optional[int] = None,
        amplitude: Optional[float] = None,
        initial: Optional[Any] = None,
        section: Optional[Any] = None,
        time: Optional[float] = None,
        duration: Optional[float] = None,
        count: Optional[int] = None,
        rtol: Optional[float] = None,
        accuracy: Optional[float] = None,
        digits: Optional[int] = None,
        job: Union[bool, str] = False,
        title: Optional[str] = None,
        save: Any = None,
        **fields: Any,
    ) -> Any:
        """A Poincaré section of a motion.

        theta: Angles from hanging, of the start.
        thetad: Angular velocities of the start.
        phi: Angles from the positive real axis, instead of theta.
        phid: Angular velocities, instead of thetad.
        unit: Unit of the start's angles.
        mode: Start in this mode, with `amplitude`, instead of angles.
        amplitude: Amplitude of the mode of the start.
        initial: The motion's start.
        section: Where the section is taken.
        time: The instant of `initial`, s, in the time of the pendulum's drives.
        duration: Duration of the motion, s.
        count: Number of passages after which the search ends; at most `max-samples`.
        rtol: Relative tolerance, as in `POST /v1/trajectories`; the method is taylor.
        accuracy: The error bound of `horizon` in the stats.
        digits: Rounds the numbers of the answer to at most this many significant digits; 6 is enough to draw.
        job: True, or a key of your own: a Job is returned at once.
        title: A name of the job in lists.
        save: A file's path, whose suffix is the format; the path is returned.
        """
        given = dict(locals())
        return self._method("section", given)

    def response(
        self,
        *,
        theta: Optional[ArrayLike] = None,
        thetad: Optional[ArrayLike] = None,
        phi: Optional[ArrayLike] = None,
        phid: Optional[ArrayLike] = None,
        unit: Optional[Literal["rad", "deg"]] = None,
        mode: Optional[int] = None,
        amplitude: Optional[float] = None,
        initial: Optional[Any] = None,
        drive: Optional[Mapping[str, Any]] = None,
        omega: Optional[Any] = None,
        output: Optional[Sequence[Literal["phi", "z", "lambda", "joint_force", "tip_force", "transmissibility", "cart"]]] = None,
        poles: Optional[bool] = None,
        digits: Optional[int] = None,
        job: Union[bool, str] = False,
        title: Optional[str] = None,
        save: Any = None,
        **fields: Any,
    ) -> Any:
        """The linear response of a driven pendulum.

        theta: Angles from hanging, of the start.
        thetad: Angular velocities of the start.
        phi: Angles from the positive real axis, instead of theta.
        phid: Angular velocities, instead of thetad.
        unit: Unit of the start's angles.
        mode: Start in this mode, with `amplitude`, instead of angles.
        amplitude: Amplitude of the mode of the start.
        initial: Start of the search for the equilibrium; its rates do not matter.
        drive: What drives the pendulum; by default its own harmonics.
        omega: Angular frequencies, rad/s, in any order, or a range of them; required with `drive`.
        output: phi: the arms' angles, rad. z: the tips' positions, m, including the pivot's motion. lambda, joint_force, tip_force.
        poles: Whether the poles of the free motion are returned.
        digits: Rounds the numbers of the answer to at most this many significant digits; 6 is enough to draw.
        job: True, or a key of your own: a Job is returned at once.
        title: A name of the job in lists.
        save: A file's path, whose suffix is the format; the path is returned.
        """
        given = dict(locals())
        return self._method("response", given)

    def controller(
        self,
        *,
        equilibrium: Optional[Any] = None,
        actuators: Optional[Mapping[str, Any]] = None,
        sensors: Optional[Mapping[str, Any]] = None,
        period: Optional[float] = None,
        delay: Optional[int] = None,
        Q: Optional[ArrayLike] = None,
        R: Optional[Any] = None,
        gains: Optional[Sequence[Any]] = None,
        digits: Optional[int] = None,
        job: Union[bool, str] = False,
        title: Optional[str] = None,
        save: Any = None,
        **fields: Any,
    ) -> Any:
        """Gains of a sampled controller about an equilibrium.

        equilibrium: Angles near the equilibrium, and the cart's position there.
        actuators: What the controller actuates.
        sensors: What is measured; only for `seen` and `unobservable`.
        period: Time between two samples, s.
        delay: Samples from the reading of the state to the output.
        Q: Weights of the state, one per number, without the delayed outputs.
        R: Weights of the outputs, one per actuator.
        gains: Gains to be analysed: one row per actuator, or the only row itself.
        digits: Rounds the numbers of the answer to at most this many significant digits; 6 is enough to draw.
        job: True, or a key of your own: a Job is returned at once.
        title: A name of the job in lists.
        save: A file's path, whose suffix is the format; the path is returned.
        """
        given = dict(locals())
        return self._method("controller", given)

    def orbits(
        self,
        *,
        mode: Optional[int] = None,
        amplitude: Optional[float] = None,
        unit: Optional[Literal["rad", "deg"]] = None,
        energy: Optional[float] = None,
        theta: Optional[ArrayLike] = None,
        thetad: Optional[ArrayLike] = None,
        phi: Optional[ArrayLike] = None,
        phid: Optional[ArrayLike] = None,
        initial: Optional[Any] = None,
        periods: Optional[int] = None,
        settle: Optional[int] = None,
        step: Optional[float] = None,
        count: Optional[int] = None,
        branch: Optional[Any] = None,
        switch: Optional[ArrayLike] = None,
        rows: Optional[Literal["orbits", "bifurcations"]] = None,
        digits: Optional[int] = None,
        job: Union[bool, str] = False,
        title: Optional[str] = None,
        save: Any = None,
        **fields: Any,
    ) -> Any:
        """Periodic orbits, their branches and their stability.

        mode: Required for a pendulum without a drive: the linear mode that is continued, from 1, the slowest first, among those that oscillate about the
            equilibrium.
        amplitude: The largest angle of any arm from its rest, where all turn back, from 1e-4 to 1000 rad; or `energy`.
        unit: Unit of the start's angles.
        energy: Energy above that of the equilibrium, J; or `amplitude`.
        theta: Angles from hanging, of the start.
        thetad: Angular velocities of the start.
        phi: Angles from the positive real axis, instead of theta.
        phid: Angular velocities, instead of thetad.
        initial: For driven pendulums, the state at t = 0 near which an orbit is searched; by default hanging at rest.
        periods: For driven pendulums, the period of an orbit in periods of the drive.
        settle: For driven pendulums, the number of periods for which the motion settles before the search.
        step: The longest step along the branch, rad; by default 0.1, or 0.3 for a single orbit.
        count: Most steps along the branch.
        branch: Whether all orbits along the branch are returned; for driven pendulums, what varies.
        switch: The bifurcations, from 1, at which the search switches to the branch that begins there, one after the other; a minus sign selects the other
            side.
        rows: The meaning of a row of the answer.
        digits: Rounds the numbers of the answer to at most this many significant digits; 6 is enough to draw.
        job: True, or a key of your own: a Job is returned at once.
        title: A name of the job in lists.
        save: A file's path, whose suffix is the format; the path is returned.
        """
        given = dict(locals())
        return self._method("orbits", given)

    def fits(
        self,
        csv: Any = None,
        *,
        theta: Optional[ArrayLike] = None,
        thetad: Optional[ArrayLike] = None,
        phi: Optional[ArrayLike] = None,
        phid: Optional[ArrayLike] = None,
        unit: Optional[Literal["rad", "deg"]] = None,
        mode: Optional[int] = None,
        amplitude: Optional[float] = None,
        initial: Optional[Any] = None,
        time: Optional[float] = None,
        data: Optional[Mapping[str, Any]] = None,
        camera: Optional[Mapping[str, Any]] = None,
        unknowns: Optional[Sequence[Mapping[str, Any]]] = None,
        fixed: Optional[Sequence[Mapping[str, Any]]] = None,
        rtol: Optional[float] = None,
        iterations: Optional[int] = None,
        loss: Optional[Literal["linear", "soft_l1", "huber", "cauchy"]] = None,
        job: Union[bool, str] = False,
        title: Optional[str] = None,
        save: Any = None,
        **fields: Any,
    ) -> Any:
        """Parameters of a pendulum from measurements.

        csv: A table: a file's path, a pandas.DataFrame or a dict of columns; or a list of these, a run each.
        theta: Angles from hanging, of the start.
        thetad: Angular velocities of the start.
        phi: Angles from the positive real axis, instead of theta.
        phid: Angular velocities, instead of thetad.
        unit: Unit of the start's angles.
        mode: Start in this mode, with `amplitude`, instead of angles.
        amplitude: Amplitude of the mode of the start.
        initial: The start, by angles; if omitted, it is estimated from the data, and its numbers are unknowns unless they are `fixed`.
        time: The instant of `initial`, s; by default the first instant of the data.
        data: Either `t` and `series`, or `csv`, or `runs`, or none of them; with `modes`, or `modes` alone.
        camera: A tip at x + i y, m, is seen at d = origin + scale e^(i rotation) w / (1 + tilt . w), where w = x + i (1 + stretch) y.
        unknowns: The unknowns other than the camera's; at least one in total, and at most 256 in all runs.
        fixed: Angles and rates of an estimated start that keep their estimates, or the values in their `guess`.
        rtol: Relative tolerance of the motions, by method `taylor`.
        iterations: Most iterations.
        loss: The loss to minimize, by SciPy's names: the sum of squares of the residuals, or a function that grows more slowly beyond 1.345 standard
            deviations (`cauchy`.
        job: True, or a key of your own: a Job is returned at once.
        title: A name of the job in lists.
        save: A file's path, whose suffix is the format; the path is returned.
        """
        given = dict(locals())
        return self._method("fits", given)

    def tables(
        self,
        csv: Any = None,
        *,
        data: Optional[Mapping[str, Any]] = None,
        theta: Optional[ArrayLike] = None,
        thetad: Optional[ArrayLike] = None,
        phi: Optional[ArrayLike] = None,
        phid: Optional[ArrayLike] = None,
        unit: Optional[Literal["rad", "deg"]] = None,
        mode: Optional[int] = None,
        amplitude: Optional[float] = None,
        initial: Optional[Any] = None,
        start: Optional[Any] = None,
        camera: Optional[Any] = None,
        loss: Optional[Any] = None,
        unknowns: Optional[Any] = None,
        fixed: Optional[Any] = None,
        rtol: Optional[Any] = None,
        iterations: Optional[Any] = None,
        include: Optional[Sequence[Literal["data"]]] = None,
        job: Union[bool, str] = False,
        title: Optional[str] = None,
        save: Any = None,
        **fields: Any,
    ) -> Any:
        """How the columns of measured tables are interpreted.

        csv: A table: a file's path, a pandas.DataFrame or a dict of columns; or a list of these, a run each.
        data: Either `t` and `series`, or `csv`, or `runs`, or none of them; with `modes`, or `modes` alone.
        theta: Angles from hanging, of the start.
        thetad: Angular velocities of the start.
        phi: Angles from the positive real axis, instead of theta.
        phid: Angular velocities, instead of thetad.
        unit: Unit of the start's angles.
        mode: Start in this mode, with `amplitude`, instead of angles.
        amplitude: Amplitude of the mode of the start.
        initial: Not read.
        start: Not read.
        camera: Not read.
        loss: Not read.
        unknowns: Not read.
        fixed: Not read.
        rtol: Not read.
        iterations: Not read.
        include: `data`: the measurements of tables with at most 300000 cells in total.
        job: True, or a key of your own: a Job is returned at once.
        title: A name of the job in lists.
        save: A file's path, whose suffix is the format; the path is returned.
        """
        given = dict(locals())
        return self._method("tables", given)

    def equations(
        self,
        *,
        theta: Optional[ArrayLike] = None,
        thetad: Optional[ArrayLike] = None,
        phi: Optional[ArrayLike] = None,
        phid: Optional[ArrayLike] = None,
        unit: Optional[Literal["rad", "deg"]] = None,
        mode: Optional[int] = None,
        amplitude: Optional[float] = None,
        initial: Optional[Any] = None,
        form: Optional[Literal["explicit", "compact"]] = None,
        job: Union[bool, str] = False,
        title: Optional[str] = None,
        save: Any = None,
        **fields: Any,
    ) -> Any:
        """Write out the equations of motion.

        theta: Angles from hanging, of the start.
        thetad: Angular velocities of the start.
        phi: Angles from the positive real axis, instead of theta.
        phid: Angular velocities, instead of thetad.
        unit: Unit of the start's angles.
        mode: Start in this mode, with `amplitude`, instead of angles.
        amplitude: Amplitude of the mode of the start.
        initial: The start of the programs; as in `POST /v1/trajectories`.
        form: How the formulas are written; by default `explicit` up to 8 arms, and `compact` for more arms and for real pendulums.
        job: True, or a key of your own: a Job is returned at once.
        title: A name of the job in lists.
        save: A file's path, whose suffix is the format; the path is returned.
        """
        given = dict(locals())
        return self._method("equations", given)
