"""docker/slurm.sbatch and docker/parts.sbatch run by a real Slurm on this machine: munged, slurmctld and slurmd of the drill's own,
PostgreSQL, one api process; an array of workers drains the queue, one of them is killed on the way, all end by themselves.

usage: slurm.py BUILD     (make slurm, as root; no part of make check)
Leaves to others: the account (house.py). Invariant: everything listens on loopback and ends with the block.
"""
import contextlib
import os
import pathlib
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

from house import House, undisturbed
from places import die_with_parent, place

TOP = pathlib.Path(__file__).resolve().parents[2]
NEEDED = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "scontrol")
PATH = os.environ.get("PATH", "") + ":/usr/sbin:/sbin"
CONF = """ClusterName=drill
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={control}
SlurmdPort={node}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={top}/munge.socket
CryptoType=crypto/munge
StateSaveLocation={top}/state
SlurmdSpoolDir={top}/spool
SlurmctldPidFile={top}/slurmctld.pid
SlurmdPidFile={top}/slurmd.pid
SlurmctldLogFile={top}/slurmctld.log
SlurmdLogFile={top}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
ReturnToService=2
SlurmdParameters=config_overrides
SchedulerParameters=batch_sched_delay=0,sched_interval=2
NodeName={host} NodeAddr=127.0.0.1 CPUs=4 RealMemory=1000 State=UNKNOWN
PartitionName=drill Nodes={host} Default=YES MaxTime=INFINITE State=UP OverSubscribe=NO
"""


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextlib.contextmanager
def slurm(top):
    """A cluster of this machine alone; yields the environment in which sbatch finds it."""
    host = socket.gethostname().split(".")[0]
    for name in ("state", "spool"):
        os.makedirs(f"{top}/{name}")
    pathlib.Path(f"{top}/key").write_bytes(os.urandom(128))
    os.chmod(f"{top}/key", 0o600)
    os.chmod(top, 0o755)
    pathlib.Path(f"{top}/slurm.conf").write_text(CONF.format(host=host, top=top, control=free_port(), node=free_port()))
    environment = os.environ | {"PATH": PATH, "SLURM_CONF": f"{top}/slurm.conf"}
    started = []
    commands = (
        ["munged", "-F", "-f", f"--socket={top}/munge.socket", f"--key-file={top}/key", f"--pid-file={top}/munge.pid",
         f"--log-file={top}/munge.log", f"--seed-file={top}/seed"],
        ["slurmctld", "-D", "-c", "-f", f"{top}/slurm.conf"],
        ["slurmd", "-D", "-c", "-N", host, "-f", f"{top}/slurm.conf"])
    try:
        for command in commands:
            with open(f"{top}/{command[0]}.out", "wb") as out:
                started.append(subprocess.Popen([shutil.which(command[0], path=PATH), *command[1:]], stdout=out, stderr=out, env=environment,
                                                preexec_fn=die_with_parent(signal.SIGTERM)))
            time.sleep(1)
        yield environment
    finally:
        for process in reversed(started):
            process.terminate()
            process.wait(30)


def call(environment, *command):
    run = subprocess.run(command, env=environment, text=True, capture_output=True)
    if run.returncode:
        raise RuntimeError(f"{' '.join(command)}: {run.stderr}")
    return run.stdout


def parts(build, top, environment):
    """The complaints about an array that computes the parts of an ensemble, the one of docker/growth.md; its first task is queued again."""
    pathlib.Path(f"{top}/request.json").write_text((TOP / "docker/growth.md").read_text().split("<<'END'\n")[1].split("END\n")[0])
    pathlib.Path(f"{top}/pendulum").write_text(f'#!/bin/sh\nmkdir {top}/tried 2>/dev/null && exit 75\nexec {build}/pendulum "$@"\n')
    pathlib.Path(f"{top}/pendulum").chmod(0o755)
    environment = environment | {"PENDULUM": f"{top}/pendulum", "PYTHONPATH": str(TOP / "api/clients/python")}
    limits = ("--mem-per-cpu=100M", "--time=5", f"--output={top}/part.out")
    array = call(environment, "sbatch", "--parsable", "--array=1-4", *limits, str(TOP / "docker/parts.sbatch"), f"{top}/request.json", f"{top}/set").strip()
    call(environment, "sbatch", "--wait", *limits, f"--dependency=afterok:{array}", "--wrap", f"/usr/bin/python3 -m pendulumd.dataset {top}/set")
    said, again = pathlib.Path(f"{top}/part.out").read_text(), call(environment, "scontrol", "-o", "show", "job", array).count("Restarts=1 ")
    return [] if "4 parts" in said and again == 1 else ["parts: no manifest, or none was queued again"]


def main():
    build = pathlib.Path(sys.argv[1]).resolve()
    missing = [name for name in NEEDED if not shutil.which(name, path=PATH)]
    if missing or os.geteuid():
        print(f"skip Slurm: {', '.join(missing) or 'this needs root'}\n0 passed, 0 failed, 1 skipped")
        return
    complaints = []
    with tempfile.TemporaryDirectory(prefix="pendulumd-drill-") as top, place("postgres") as store, slurm(top) as environment:
        right = undisturbed(build, top)
        house = House(build, store, random.Random(1), top, right)
        try:
            house.start("api")
            store.watch()
            jobs = [house.submit(kind) for kind in ("map", "walk") * 12]
            environment |= {"PENDULUMD": str(build / "pendulumd"), "PENDULUMD_STORE": store.url, "PENDULUMD_JOB_LEASE_SECONDS": "1",
                            "PENDULUMD_JOB_PART_SECONDS": "0.1", "PENDULUMD_UNTIL_IDLE_SECONDS": "4", "PENDULUMD_ACCESS_LOG": "off"}
            array = call(environment, "sbatch", "--parsable", "--array=1-4", "--cpus-per-task=1", "--mem-per-cpu=100M", "--time=5",
                         f"--output={top}/worker-%a.out", str(TOP / "docker/slurm.sbatch")).split(";")[0].strip()
            end = time.monotonic() + 60
            while call(environment, "squeue", "-h", "-r", "-t", "RUNNING").count("\n") < 4 and time.monotonic() < end:
                time.sleep(0.1)
            running = call(environment, "squeue", "-h", "-r", "-o", "%i %T")
            print(f"array {array}:", running.replace("\n", "; "))
            time.sleep(0.3)
            call(environment, "scancel", "--full", "--signal=KILL", f"{array}_2")
            house.finish(jobs)
            end = time.monotonic() + 120
            while (left := call(environment, "squeue", "-h", "-r", "-o", "%i %T")) and time.monotonic() < end:
                time.sleep(0.2)
            if left:
                complaints.append(f"workers that did not end: {left}")
            ends = call(environment, "scontrol", "-o", "show", "job", array)
            for line in ends.splitlines():
                words = dict(word.split("=", 1) for word in line.split() if "=" in word)
                print(f"  task {words.get('ArrayTaskId')}: {words.get('JobState')}, exit {words.get('ExitCode')}, {words.get('RunTime')}")
                if words.get("JobState") != "COMPLETED" and words.get("ArrayTaskId") != "2":  # that one was killed; it may come back
                    complaints.append(line)
            if len(ends.splitlines()) != 4:
                complaints.append(f"not four tasks: {ends}")
            accepted, lost, twice, wrong, more = house.account()
            print(f"  {accepted} accepted, {lost} lost, {twice} twice, {wrong} wrong")
            complaints += more + parts(build, top, environment)
        except Exception:
            for log in sorted(pathlib.Path(top).glob("*.log")) + sorted(pathlib.Path(top).glob("*.out")):
                print(f"--- {log.name}\n" + "\n".join(log.read_text(errors="replace").splitlines()[-8:]))
            raise
        finally:
            house.close()
    for text in complaints:
        print(f"FAIL {text}")
    print(f"{int(not complaints)} passed, {int(bool(complaints))} failed")
    sys.exit(bool(complaints))


if __name__ == "__main__":
    main()
