"""The Python client against a live server: its README, what comes back, refusals, lines that break, jobs, asyncio.

Leaves to others: the numbers themselves (tests/laws), the other clients (tests/rules/clients.py).
Invariant: the package that is tested is the one that pip has installed.
"""
import asyncio
import glob
import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time
import warnings
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from clients import DOUBLE, FOUR, TOP, programs
from front import PAGE, Front
from rule import check, optional, shipped_nginx, skip
from servers import nginx, tool


def install(home):
    """`pip install` of the folder, without a network, into a directory of its own; the folder stays as it was."""
    source, target = TOP / "api/clients/python", home / "python"
    before = sorted(source.rglob("*"))
    done = subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", "--no-index", "--no-deps",
                           "--disable-pip-version-check", "--target", target, source], capture_output=True, text=True)
    check("pip install of the folder", done.returncode == 0, done.stdout + done.stderr)
    check("pip leaves no files in the folder", [one for one in sorted(source.rglob("*")) if "__pycache__" not in str(one)] == [one for one in before if "__pycache__" not in str(one)])
    sys.path.insert(0, str(target))


def test_results(client):
    from pendulumd import Pendulum, Problem
    four = Pendulum(client, **FOUR)
    motion = four.run("0:5:0.01", output=["phi", "lambda", "z", "energy"])
    plain = json.loads(client.call("trajectories", four.request(times={"start": 0, "stop": 5, "step": 0.01}, output=["phi", "lambda", "z", "energy"]),
                                   accept="application/json"))
    check("arrays are those of the JSON", np.array_equal(motion.phi, plain["phi"]) and np.array_equal(motion.lambda_, plain["lambda"])
          and np.array_equal(motion.z, np.array(plain["z"]["re"]) + 1j * np.array(plain["z"]["im"]))
          and np.array_equal(motion.energy_total, plain["energy"]["total"]))
    check("instants by their number", np.array_equal(four.run("0:5/501").t, motion.t))
    check("statistics", motion.stats["method"] == "taylor" and motion.stats["steps"] == plain["stats"]["steps"] and motion.warnings == [])
    for name, make in (("pandas", motion.to_pandas if optional("pandas") else None), ("xarray", motion.to_xarray if optional("xarray") else None)):
        if not make:
            skip(f"tables of {name}", "it is not installed")
            continue
        table = make()
        phi = table["phi_3"].to_numpy() if name == "pandas" else table["phi"].sel(arm=3).to_numpy()
        index = table.index if name == "pandas" else table.t
        check(f"tables of {name}", np.array_equal(phi, motion.phi[:, 2]) and np.array_equal(index, motion.t) and table.attrs["method"] == "taylor")
    if optional("xarray"):
        check("units in xarray", table["phi"].attrs == {"units": "rad"} and table["energy_total"].attrs == {"units": "J"})
        grid = Pendulum(client, **DOUBLE).ensemble(states=[{"theta": [2, 2]}, {"theta": [1, 0]}], duration=5, observables=["first_flip", "flips"])
        check("an ensemble in xarray", grid.to_xarray().sizes == {"member": 2, "arm": 2}, grid.to_xarray())
    test_grids(Pendulum(client, **DOUBLE))
    with tempfile.TemporaryDirectory() as home:
        track = pathlib.Path(home) / "track.csv"
        track.write_text("Zeit;Winkel (\xb0)\n" + "".join(f"{i / 10};{np.cos(i / 3):.4f}\n" for i in range(30)), encoding="utf-16")
        one = Pendulum(client, length=[1], mass=[1], parent=[0])
        length = [{"vary": "length", "arm": 1}]
        check("tables from a file", [column["is"] for column in one.tables(track)["tables"][0]["columns"]] == ["t", "theta 1"])
        check("fits of files", one.fits(track, unknowns=length)["status"] == "converged" and len(one.fits([track, track], unknowns=length)["runs"]) == 2)
        frames = "".join(f'<property name="[{10 + i}]" type="object"><object class="org.opensourcephysics.cabrillo.tracker.PointMass$FrameData"><property name="x" type="double">'
                         f'{320 + 200 * np.sin(0.6 * np.cos(i / 3)):.3f}</property><property name="y" type="double">{40 + 200 * np.cos(0.6 * np.cos(i / 3)):.3f}</property></object></property>' for i in range(30))
        tracker, media = "org.opensourcephysics.cabrillo.tracker.", "org.opensourcephysics.media.core."
        (pathlib.Path(home) / "swing.trk").write_text(f'<?xml version="1.0" encoding="UTF-8"?><object class="{tracker}TrackerPanel"><property name="startframe" type="int">10</property>'
            f'<property name="delta_t" type="double">100.0</property><object class="{media}ImageCoordSystem"><object class="{media}ImageCoordSystem$FrameData"><property name="xorigin" type="double">320</property>'
            f'<property name="yorigin" type="double">40</property><property name="xscale" type="double">200</property></object></object><object class="{tracker}PointMass"><property name="framedata" type="array">{frames}</property></object></object>')
        np.savez(pathlib.Path(home) / "swing.npz", t=np.arange(30) / 10, theta=np.cos(np.arange(30) / 3)[:, None])
        for kind in ("trk", "npz", "mat")[:3 if optional("scipy") else 2]:
            if kind == "mat":
                __import__("scipy.io").io.savemat(pathlib.Path(home) / "swing.mat", {"t": np.arange(30) / 10, "theta": np.cos(np.arange(30) / 3)[:, None]})
            fit = one.fits(pathlib.Path(home) / f"swing.{kind}", unknowns=length)
            check(f"fits of .{kind}", fit["status"] == "converged" and fit["explained"] > 0.9 and fit["tables"][0]["rows"] == 30, fit)
        columns = {"t": np.arange(30) / 10, "theta": np.cos(np.arange(30) / 3)}
        same = one.fits(columns, unknowns=length)
        check("fits of columns", same["status"] == "converged" and (not optional("pandas") or __import__("pandas").DataFrame(columns).to_csv is not None
              and one.fits(__import__("pandas").DataFrame(columns), unknowns=length)["unknowns"] == same["unknowns"]))
    blocks = list(four.stream("0:5:0.01", rows=200, output=["phi", "lambda", "z", "energy"]))
    check("blocks are the same rows", [len(block.t) for block in blocks] == [200, 200, 101]
          and np.array_equal(np.concatenate([block.z for block in blocks]), motion.z))
    rest = four.forces(phi=[0, 0, 0, 0])
    check("forces, modes, matrices, the tree", rest.phidd.shape == (4,) and four.modes().omega.shape == (4,)
          and four.modes(include=["A"]).A.shape == (4, 4) and list(four.tree().depth) == [1, 2, 3, 3])
    check("a range, an array and a pendulum of one arm", Pendulum(client, length=np.ones(1), mass=[1], parent=range(1)).run(np.linspace(0, 1, 3)).phi.shape == (3, 1))
    check("fields of real pendulums", Pendulum(client, **DOUBLE, damping=[0.1, 0.2]).tree().arms[1]["damping"] == 0.2)
    check("a preset", Pendulum.preset("paper-four-arms", client).run([0, 1]).phi.shape == (2, 4))
    for what, ask, words in (("a field of the request", lambda: four.run([0, 1], fruit=3), "/fruit is not a known field"),
                             ("a field of the pendulum", lambda: Pendulum(client, **FOUR, fruit={"a": [1]}).run([0, 1]), "/pendulum/fruit")):
        try:
            ask()
            check(f"{what} that is not known reaches the server", False, "no refusal")
        except Problem as problem:
            check(f"{what} that is not known reaches the server", problem.status == 422 and words in str(problem) and len(problem.errors) == 1, problem)


def test_grids(double):
    """Members of a grid: integers, NaN for never, axes as dimensions, members one after another."""
    axes = [{"vary": "theta", "arm": 1, "start": -3, "stop": 3, "count": 4}, {"vary": "theta", "arm": 2, "start": -2, "stop": 2, "count": 3}]
    grid = double.ensemble(grid=axes, duration=3, observables=["start", "first_flip"])
    check("instants as a text in an ensemble", double.ensemble(states=[{}], times="0:1/3", observables=["trajectory"]).t.tolist() == [0, 0.5, 1])
    check("numbers that count are integers", all(grid[name].dtype == np.int64 for name in ("member", "status", "first_flip_arm")))
    check("never is NaN", np.array_equal(np.isnan(grid.first_flip_time), grid.first_flip_arm == 0) and np.isnan(grid.first_flip_time).any())
    check("the axes of a grid", [list(values) for values in grid.axes().values()] == [[-3, -1, 1, 3], [-2, 0, 2]])
    if optional("pandas"):
        frame = grid.to_pandas()
        check("a grid in pandas has its axes", np.allclose(frame["theta_1"] - np.pi / 2, grid.start_phi[:, 0]) and np.allclose(frame["theta_2"] - np.pi / 2, grid.start_phi[:, 1]))
    if optional("xarray"):
        array = grid.to_xarray()
        check("a grid in xarray has its axes", array["start_phi"].dims == ("theta_2", "theta_1", "arm")
              and np.allclose(array["start_phi"].sel(theta_1=1, theta_2=-2), [1 - np.pi / 2, -2 - np.pi / 2]) and "member" not in array)
        moving = double.ensemble(grid=axes, times={"stop": 1, "count": 5}, observables=["trajectory"]).to_xarray()
        check("and its instants", dict(moving.sizes) == {"theta_2": 3, "theta_1": 4, "t": 5, "arm": 2} and list(moving.t) == [0, 0.25, 0.5, 0.75, 1])
    ways = list(double.members(grid=axes, times="0:1:0.25", observables=["trajectory"], rows=7))
    check("members one after another", [list(way.member) for way in ways] == [[k] * 5 for k in range(12)])


def test_methods(client):
    """Methods have the parameters of the document; answers that only JSON carries whole are asked for in it; pictures need no server."""
    from pendulumd import Pendulum, operations
    folder = TOP / "api/clients/python"
    made = subprocess.run([sys.executable, "-B", folder / "operations.py"], capture_output=True, text=True)
    check("pendulumd/operations.py is what openapi.yaml says; else: operations.py > pendulumd/operations.py", made.stdout == (folder / "pendulumd/operations.py").read_text(), made.stderr)
    double = Pendulum([1, 1], [1, 1], [0, 1], client=client)
    check("every operation is a method", all(hasattr(double, name) for name in operations.ROUTES))
    moved = double.run("0:2:0.5", theta=[1, 0], events=[{"of": "theta", "arm": 1, "value": 0}])
    check("events beside samples", len(moved.t) == 5 and moved["events"][0]["event"] == 1, moved)
    check("poles", len(double.response(drive={"pivot": {"x": 1}}, omega=[1, 2], poles=True)["poles"]["omega"]) == 2)
    check("orbits keep how they end, modes their identity", "message" in double.orbits(mode=1, amplitude=0.5) and "identity" in double.modes())
    check("one name of an energy", np.isclose(double.forces(theta=[1, 1]).energy_total, double.run([0, 1], theta=[1, 1], output=["energy"]).energy_total[0]))
    check("a pendulum and an answer show themselves", "circle" in double._repr_html_() and "polyline" in moved._repr_html_() and "phi" in repr(moved) and "phi" in dir(moved))
    tips = double.run("0:1:0.1", theta=[1, 2], output=["phi", "z"])
    check("places from angles", np.allclose(double.tree_positions(tips.phi), tips.z, atol=1e-14))
    if not optional("matplotlib"):
        skip("plots", "matplotlib is not installed")
        return
    import matplotlib
    matplotlib.use("Agg")
    line = tips.plot("phi").get_lines()[1]
    check("a plot has the columns over time", np.array_equal(line.get_ydata(), tips.phi[:, 1]) and np.array_equal(line.get_xdata(), tips.t))
    check("an animation has the last place", np.allclose(tips.animate()._func(10)[0].get_xdata(), [0, tips.z[10, 0].real]))


def test_types():
    """The package and a program of a user hold under mypy's strictest rules."""
    if not shutil.which("mypy"):
        skip("type hints", "mypy is not installed")
        return
    done = subprocess.run(["mypy", "--strict", "--cache-dir", "/dev/null", "pendulumd"], cwd=TOP / "api/clients/python", capture_output=True, text=True)
    check("mypy --strict", done.returncode == 0, done.stdout)


def test_local(client):
    """The engine in this process brings the bytes of the server, also to threads side by side."""
    library = pathlib.Path(os.environ["PENDULUM_BUILD"]) / "libpendulum.so"
    if not library.exists():
        skip("the engine in the process", "libpendulum.so is not built")
        return
    os.environ["PENDULUM_LIBRARY"] = str(library)
    from pendulumd import Local, Pendulum, Problem
    local = Local()
    for route, request in (("trajectories", {"pendulum": FOUR, "times": {"stop": 5, "step": 0.01}, "output": ["phi", "lambda"]}), ("modes", {"pendulum": FOUR}),
                           ("ensembles", {"pendulum": DOUBLE, "grid": [{"vary": "theta", "arm": 1, "start": 0, "stop": 3, "count": 50}], "duration": 10, "observables": ["final"]})):
        accept = "application/json" if route == "modes" else "application/octet-stream"
        there, here = (re.sub(rb',"compute_seconds":[^,}]*', b"", one.call(route, request, accept)) for one in (client, local))
        check(f"local {route}", here == there)
        here, there = local.call(route, request), client.call(route, request)
        check(f"local {route} as arrays", list(here) == list(there) and all(np.array_equal(value, there[name], equal_nan=True) for name, value in here.items()
              if isinstance(value, np.ndarray)) and here.stats == {name: value for name, value in there.stats.items() if name != "compute_seconds"})
    double = Pendulum([1, 1], [1, 1], [0, 1], client="local")
    with ThreadPoolExecutor(4) as pool:
        ends = list(pool.map(lambda k: double.run("0:5:0.01", theta=[k / 10, 1]).phi[-1], range(40)))
    check("threads side by side", all(np.array_equal(end, Pendulum(client, **DOUBLE).run("0:5:0.01", theta=[k / 10, 1]).phi[-1]) for k, end in enumerate(ends)))
    check("blocks and a preset", [len(block.t) for block in double.stream("0:1:0.1", rows=4)] == [4, 4, 3]
          and Pendulum.preset("paper-four-arms", local).run([0, 1]).phi.shape == (2, 4))
    ends = []
    for block in double.stream("0:100:0.001", rows=20000, theta=[1, 1]):
        double.modes()
        ends.append(block.phi[-1])
    check("other requests between two blocks", np.array_equal(ends[-1], double.run("0:100:0.001", theta=[1, 1]).phi[-1]) and len(ends) == 6)
    check("blocks that nobody takes", len(next(double.stream("0:100:0.001", rows=100)).t) == 100 and double.modes().omega.shape == (2,))
    try:
        double.run([0, 1], fruit=3)
        check("a refusal of the engine", False)
    except Problem as problem:
        check("a refusal of the engine", problem.status == 422 and "/fruit" in str(problem))


def test_mistakes(client, home):
    """What would be sent as something else, or end in a word of Python's that says nothing, is told before it is sent."""
    from pendulumd import Pendulum
    four = Pendulum(client, **FOUR)
    for what, ask, words in (("a set has no order", lambda: four.run([0, 1], theta={1, 2, 3, 4}), "a set cannot be sent"),
                             ("a start given twice", lambda: four.run([0, 1], initial={"theta": [1, 2, 3, 4]}, theta=[0, 0, 0, 0]), "given twice"),
                             ("a form that there is not", lambda: four.run([0, 1], save=home / "a.xlsx"), ".parquet"),
                             ("what is no number", lambda: four.run([0, 1], theta=[float("nan")] * 4), "finite"),
                             ("a preset's name", lambda: Pendulum("double"), "Pendulum.preset")):
        try:
            ask()
            check(f"told: {what}", False, "no refusal")
        except (TypeError, ValueError) as error:
            check(f"told: {what}", words in str(error), repr(error))


def test_trouble(server, client):
    from pendulumd import Client, Pendulum, Problem
    front = Front(server.port)
    four = Pendulum(Client(front.url, patience=20), **FOUR)
    wanted = Pendulum(client, **FOUR).run("0:5:0.01")
    front.moods = [("refuse", "429 Too Many Requests", "Retry-After: 1"), ("refuse", "503 Service Unavailable", "Retry-After: 0"), ("cut", 0)]
    begin = time.monotonic()
    check("refusals for the moment are repeated", np.array_equal(four.run("0:5:0.01").phi, wanted.phi) and len(front.heads) == 4, front.heads)
    check("Retry-After is waited for", time.monotonic() - begin >= 1)
    front.moods = [("cut", 3000)]
    check("an answer that was cut off is asked for again", np.array_equal(Pendulum(Client(front.url), **FOUR).run("0:5:0.01").phi, wanted.phi))
    for what, moods, kind in (("refused for longer than its patience", [("refuse", "429 Too Many Requests", "Retry-After: 60")], Problem),
                              ("cut at each try", [("cut", 3000)] * 2, Exception)):
        front.moods = moods
        try:
            Pendulum(Client(front.url, patience=5), **FOUR).run("0:5:0.01")
            check(f"what is {what} is raised", False, "it was answered")
        except kind as problem:
            check(f"what is {what} is raised", not isinstance(problem, Problem) or problem.status == 429, problem)
    pages = Front(server.port)
    pages.moods = [PAGE]
    for what, url, words in (("no server", "http://127.0.0.1:1", "no server at http://127.0.0.1:1 ("), ("another server", pages.url, "answers with a web page"),
                             ("no url", "127.0.0.1:8080", "such as http://127.0.0.1:8080")):
        try:
            Pendulum(Client(url, patience=1e6), **FOUR).run("0:5:0.01")  # at once: who waits for it here waits for days
            check(f"{what} is told", False, "it was answered")
        except (ConnectionError, Problem, ValueError) as error:
            check(f"{what} is told with where it is said", words in str(error) and "PENDULUM_URL or Client(url)" in str(error), error)
    pages.close()
    front.moods = [("cut", 30000)]
    try:
        rows = sum(len(block.t) for block in Pendulum(Client(front.url), **FOUR).stream("0:50:0.001", rows=100))
        check("a stream that was cut off is not taken for whole", False, f"{rows} rows")
    except Exception as error:
        check("a stream that was cut off is not taken for whole", "IncompleteRead" in type(error).__name__, repr(error))
    front.close()


def test_nginx(server):
    """Behind the shipped nginx, here with 20 requests a second and 40 at once: all of eighty are answered, the last after two seconds."""
    from pendulumd import Client, Pendulum
    if not tool("nginx"):
        skip("eighty requests behind nginx", "it is not installed")
        return
    narrow = [("rate=100r/s", "rate=20r/s"), ("client_requests burst=200", "client_requests burst=40")]
    with nginx(shipped_nginx([server.port], changes=narrow)) as proxy, ThreadPoolExecutor(16) as pool:
        double = Pendulum(Client(proxy.url, patience=30), **DOUBLE)
        begin = time.monotonic()
        ends = list(pool.map(lambda k: double.run("0:1:0.5", theta=[k / 100, 0]).phi[0, 0], range(80)))
        check("eighty requests behind the shipped nginx", np.allclose(ends, np.arange(80) / 100 - np.pi / 2), ends)
        check("of which it has put some off", time.monotonic() - begin > 1.5)


def test_files(client, home):
    """What `save` may replace, and the warnings of forms that have no place for them."""
    request = {"pendulum": DOUBLE, "times": {"stop": 40, "step": 0.001}, "initial": {"theta": [0.1, 0.1]}}
    lost = request | {"initial": {"theta": [2, 2]}}
    whole = client.call("trajectories", request, "application/octet-stream")
    place, target, link, pipe = home / "saves", home / "saves/deep.bin", home / "saves/link.bin", home / "saves/pipe.bin"
    place.mkdir()
    target.write_bytes(b"old")
    target.chmod(0o640)
    link.symlink_to("deep.bin")
    client.save("trajectories", request, link)
    check("a link's target is replaced and keeps its mode", link.is_symlink() and target.read_bytes() == whole and target.stat().st_mode & 0o777 == 0o640)
    target.chmod(0o440)
    try:
        client.save("trajectories", lost, link)
        check("a read-only file is refused", False, "it was replaced")
    except PermissionError:
        check("a read-only file is left", target.read_bytes() == whole)
    os.mkfifo(pipe)
    reader = subprocess.Popen(["cp", pipe, home / "piped.bin"])
    client.save("trajectories", request, pipe)
    check("a pipe stays one", reader.wait(60) == 0 and (home / "piped.bin").read_bytes() == whole and pipe.is_fifo())
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(lambda each: client.save("trajectories", each, place / "both.bin"), [request, request | {"rtol": 1e-9}] * 2))
    check("two saves into one file leave one of the answers", len((place / "both.bin").read_bytes()) == len(whole)
          and (place / "both.bin").read_bytes() in (whole, client.call("trajectories", request | {"rtol": 1e-9}, "application/octet-stream")))
    check("no temporary file is left", sorted(each.name for each in place.iterdir()) == ["both.bin", "deep.bin", "link.bin", "pipe.bin"])
    for what, ask in (("save", lambda: client.save("trajectories", lost, place / "lost.bin")), ("stream", lambda: list(client.stream("trajectories", lost)))):
        with warnings.catch_warnings(record=True) as heard:
            warnings.simplefilter("always")
            ask()
        check(f"the warning of {what}", len(heard) == 1 and re.search(r"t = 1[23]\.\d+ s", str(heard[0].message)), heard)


def test_jobs(server, client, home):
    from pendulumd import Client, Pendulum, Problem
    four, looks = Pendulum(client, **FOUR), []
    job = four.run("0:40:0.001", job="one-of-mine")
    check("a key leads to the same job", four.run("0:40:0.001", job="one-of-mine").id == job.id)
    motion = job.result(progress=lambda job: looks.append(job.progress))
    check("a job's result is the answer", np.array_equal(motion.phi, four.run("0:40:0.001").phi) and looks[-1] == 100, looks)
    check("the list has it", job.id in [each.id for each in client.jobs()])
    named = client.submit("forces", {"pendulum": {"length": [1], "mass": [1], "parent": [0]}}, title="fünf % of it")
    check("a title finds its job alone", [each.state["title"] for each in client.jobs(title="nf % OF", operation="forces")] == ["fünf % of it"], named.state)
    front = Front(server.port)
    again = Client(front.url, token=os.environ["PENDULUM_TOKEN"]).job(job.id)
    front.moods = [("cut", 1000000), ("cut", 2000000)]
    again.client._idle.clear()
    front.heads.clear()
    check("a download goes on by Range", np.array_equal(again.result().phi, motion.phi), "other bytes")
    ranges = [head for head in front.heads if "Range: bytes=" in head]
    check("and asks for what is missing only", len(ranges) == 2 and all("If-Range" in head for head in ranges), front.heads)
    test_files(client, home)
    # half a file of an earlier process, and one that belongs to another answer
    path = home / "motion.npz"
    job.save(path)
    whole = path.read_bytes()
    etag = client._open("HEAD", f"/v1/jobs/{job.id}/results", None, {"Accept": "application/x-npz"})[1].headers["ETag"].strip('"')
    for beginning in (whole[:100000], whole, whole + b"more"):
        (home / f"motion.npz.part-{etag[:32]}").write_bytes(beginning)
        job.save(path)
        check(f"a file of which {len(beginning)} bytes were there", path.read_bytes() == whole and not glob.glob(f"{path}.part*"))
    # a job knows of itself that its numbers have 4 bytes
    narrow = four.run("0:1:0.5", job=True, number="float32", output=["phi", "z"])
    found, plain = list(client.job(narrow.id).stream(rows=2)), four.run("0:1:0.5", output=["phi", "z"])
    check("a job of floats is streamed as floats", [len(block.t) for block in found] == [2, 1] and found[0].phi.dtype == np.float32
          and np.array_equal(np.concatenate([block.phi for block in found]), plain.phi.astype(np.float32))
          and np.array_equal(np.concatenate([block.z for block in found]), plain.z.astype(np.complex64)), found)
    check("a job has its request", narrow.request()["number"] == "float32" and narrow.request()["output"] == ["phi", "z"], narrow.request())
    wide = four.run("0:1:0.5", job=True, output=["phi", "z"])
    check("and one of doubles as doubles", np.array_equal(np.concatenate([block.phi for block in wide.stream(rows=2)]), plain.phi))
    long = four.run("0:4000:0.001", job=True)
    check("cancel ends a job", long.cancel().status == "dismissed")
    try:
        long.result()
        check("a dismissed job has no result", False)
    except Problem as problem:
        check("a dismissed job has no result", "dismissed" in str(problem))
    front.close()


def test_asyncio(client):
    from pendulumd import Pendulum
    double = Pendulum(client, **DOUBLE)

    async def main():
        motions = await asyncio.gather(*(double.aio.run("0:5:0.01", theta=[1, k / 10]) for k in range(20)))
        check("twenty at once", all(np.array_equal(motion.phi, double.run("0:5:0.01", theta=[1, k / 10]).phi) for k, motion in enumerate(motions)))
        rows = [len(block.t) async for block in double.aio.stream("0:10:0.001", rows=4000)]
        check("blocks", rows == [4000, 4000, 2001], rows)
        job = await double.aio.run("0:5:0.01", job=True)
        check("a job", len((await job.result()).t) == 501)
        check("its request and its rows", (await job.request())["times"]["step"] == 0.01 and [len(block.t) async for block in job.stream()] == [501])
        draw = [{"vary": "theta", "arm": 1, "distribution": "uniform", "low": -3, "high": 3}]
        long = asyncio.ensure_future(double.aio.ensemble(random={"count": 150000, "draw": draw}, duration=60))
        await asyncio.sleep(0.2)
        long.cancel()
        await asyncio.wait([long])
        check("a task that is cancelled ends", long.cancelled())
    asyncio.run(main())


def test_dataset(client, home):
    from pendulumd import Pendulum
    from pendulumd.dataset import WANTED, _alone, dataset
    double, folder, splits = Pendulum(client, **DOUBLE), home / "set", {"train": 25, "validation": 7, "test": 10}
    draw = [{"vary": "theta", "arm": arm, "distribution": "uniform", "low": -3, "high": 3} for arm in (1, 2)]
    about = {"draw": draw, "seed": 7, "duration": 2, "observables": ["start", "first_flip"], "card": dict.fromkeys(WANTED, "https://example.org")}
    card = dataset(double, folder, splits, shard=10, form=".csv", **about)
    check("the card is the file", json.loads((folder / "croissant.json").read_text()) == card)
    files = {one["name"]: one for one in card["distribution"] if one["@type"] == "cr:FileObject"}
    check("every file but the card stands in it", sorted(files) == sorted(one.name for one in folder.iterdir() if one.name != "croissant.json"))
    check("digests and sizes are the files'", all(hashlib.sha256((folder / name).read_bytes()).hexdigest() == one["sha256"]
          and one["contentSize"] == f"{(folder / name).stat().st_size} B" for name, one in files.items()))
    check("what Croissant 1.0 demands", card["conformsTo"] == "http://mlcommons.org/croissant/1.0" and card["@type"] == "sc:Dataset"
          and {*WANTED, "@context", "datePublished", "distribution", "recordSet"} <= card.keys())
    sets = {one["@id"]: one for one in card["recordSet"]}
    ids = [one["@id"] for one in [*card["distribution"], *sets.values(), *(field for record in sets.values() for field in record["field"])]]
    check("every id is one thing's, and every reference leads to one", len(set(ids)) == len(ids) and all(
        source["fileSet"]["@id"] in ids for source in (field.get("source") for field in sets["members"]["field"]) if source)
        and sets["members"]["field"][0]["references"]["field"]["@id"] in ids and sets["splits"]["key"]["@id"] in ids)
    regex, members = sets["members"]["field"][0]["source"]["transform"]["regex"], {}
    for name in files.keys() - {"request.json"}:
        rows = [line.split(",") for line in (folder / name).read_text().splitlines() if not line.startswith("#")]
        check(f"{name}: its columns are the card's", rows[0] == [field["source"]["extract"].get("column") for field in sets["members"]["field"][1:]])
        members.setdefault(re.match(regex, name)[1], {}).update({int(row[0]): row for row in rows[1:]})
    numbers = [number for split in splits for number in sorted(members[split])]
    check("each member is in one split", {split: len(some) for split, some in members.items()} == splits and numbers == list(range(42)), numbers)
    whole = double.ensemble(random={"count": 42, "seed": 7, "draw": draw}, duration=2, observables=["start", "first_flip"])
    came = np.array([members[split][number][2:4] for split in splits for number in sorted(members[split])], float)
    check("members are those of one request for all", np.array_equal(came, whole.start_phi))
    gone, kept = folder / "train-00001-of-00003.csv", folder / "test-00000-of-00001.csv"
    before, seen = gone.read_text(), kept.stat().st_mtime_ns
    gone.unlink()
    dataset(double, folder, splits, shard=10, form=".csv", **about)
    check("what is missing is made again, and nothing else", gone.read_text() == before and kept.stat().st_mtime_ns == seen)
    twins = [home / "one", home / "other"]
    with ThreadPoolExecutor(2) as pool:
        cards = list(pool.map(lambda twin: dataset(double, twin, splits, shard=5, form=".csv", **about), twins))
    check("two that are equal are made at once, each of jobs of its own", cards[0]["distribution"] == cards[1]["distribution"] and
          all((twins[0] / one["name"]).read_bytes() == (twins[1] / one["name"]).read_bytes() for one in cards[0]["distribution"] if "sha256" in one))
    with _alone(folder):
        try:
            dataset(double, folder, splits, shard=10, form=".csv", **about)
            check("one folder is made by one at a time", False)
        except ValueError as error:
            check("one folder is made by one at a time", "another process" in str(error), error)
    for wrong in ({"seed": 8}, {"card": {"name": "mine"}}, {"form": ".png"}):
        try:
            dataset(double, folder, splits, **{"shard": 10, "form": ".csv"} | about | wrong)
            check(f"refused: {wrong}", False)
        except ValueError:
            check(f"refused: {wrong}", True)
    (folder / "request.json").unlink()
    try:
        dataset(double, folder, splits, shard=10, form=".csv", **about | {"seed": 8})
        check("files of a set that nobody knows are not taken for others", False)
    except ValueError:
        check("files of a set that nobody knows are not taken for others", kept.stat().st_mtime_ns == seen)


def test_python(server, home):
    install(home)
    from pendulumd import Client
    client = Client()
    test_results(client)
    test_methods(client)
    test_local(client)
    test_types()
    test_mistakes(client, home)
    test_trouble(server, client)
    test_nginx(server)
    test_jobs(server, client, home)
    test_asyncio(client)
    test_dataset(client, home)
    programs("python", [sys.executable, "-B", "-c"], {"PYTHONPATH": str(home / "python")})
    return Client().call("trajectories", {"pendulum": FOUR, "times": {"start": 0, "stop": 5, "step": 0.01}}, accept="application/octet-stream")
