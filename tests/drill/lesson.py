"""A lesson of 45 minutes, its time compressed: thirty pupils, a teacher with two tabs who makes mistakes, and restarts.

usage: lesson.py BUILD [sqlite|postgres ...] [--seconds S] [--seed N]        (make lesson: both stores, 45 s each)
On SQLite one process serves, on PostgreSQL three. The teacher shows the wrong scene and the right one again, freezes twice, erases
questions that have answers, and acts in two tabs at the same moment; pupils join twice; processes are restarted and killed, and
PostgreSQL is restarted and crashes. Who gets no answer asks again, whoever serves. It tells times, and fails when an accepted answer
is not in the table just once with its last value, when a histogram differs from the table, when a stream that was resumed has told
something twice or lacks something, or when anybody gets a refusal that is not the teacher's will.

Leaves to others: pages in browsers (tests/web/lesson.mjs), latency of many rooms (tests/load/classes.py), single rules (tests/wire).
Invariant: traffic stays on loopback; what was started ends.
"""
import argparse
import collections
import contextlib
import csv
import http.client
import io
import json
import pathlib
import random
import signal
import sys
import tempfile
import threading
import time

from house import Daemon
from places import place, postgres_programs

TOP = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(TOP / "tests/rules"))
from rule import check, skip, summary  # noqa: E402

PUPILS, MINUTES, PATIENCE = 30, 45, 60.0
OPTIONS = ("--max-event-streams", "400", "--drain-idle-seconds", "0.2")
TEXTS = ("as long as it wants", "=1+1", 'it says "no", then\nswings, and stops', "ö ✓", "<b>2 s</b>")
SHEET = {"title": "Three steps", "steps": [{"id": f"step-{i}", "question": {"kind": "number", "text": f"{i}?"}} for i in range(3)]}


def scene(angle):
    return {"request": {"pendulum": {"length": [1, 1], "mass": [1, 1], "parent": [0, 1]}, "initial": {"theta": [angle, 0]},
                        "times": {"start": 0, "stop": 10, "count": 101}}}


class Lesson:
    """The processes, and what everybody has seen."""

    def __init__(self, build, store, directory, processes, minute, seed):
        self.build, self.place, self.directory, self.minute, self.dice = build, store, directory, minute, random.Random(seed)
        self.over, self.lock, self.begun = threading.Event(), threading.Lock(), 0.0
        self.times, self.late, self.shown, self.resumed, self.errors = [], [], [], [], []
        self.counts, self.path = collections.Counter(), None
        self.daemons = [self.start() for _ in range(processes)]

    def start(self):
        return Daemon(self.build, self.place.url, "all", self.directory, OPTIONS)

    def error(self, what):
        with self.lock:
            self.errors.append(what)

    def count(self, what):
        with self.lock:
            self.counts[what] += 1

    def replace(self, i, how):
        """Ends a process by a signal, and starts another in its place, at another port."""
        status = self.daemons[i].kill(how)
        if how == signal.SIGTERM and status:
            self.error(f"a process ended with {status}")
        self.daemons[i] = self.start()

    def at(self, minute):
        time.sleep(max(0.0, self.begun + minute * self.minute - time.monotonic()))


class Member:
    """Somebody in the room: asks, and listens in a thread of its own; a stream that ends is resumed."""

    def __init__(self, lesson, name, token=None):
        self.lesson, self.name, self.line, self.turn = lesson, name, None, lesson.dice.randrange(100)
        self.token = token or f"{lesson.dice.getrandbits(128):032x}"
        self.number, self.kept, self.handed, self.dice = 0, {}, [], random.Random(self.token)
        self.items, self.last, self.ended, self.arrived = {}, 0, threading.Event(), []
        self.ear = threading.Thread(target=self.hear, daemon=True)

    def open(self):
        """A connection to whichever process has its turn."""
        self.turn += 1
        return http.client.HTTPConnection("127.0.0.1", self.lesson.daemons[self.turn % len(self.lesson.daemons)].port, timeout=PATIENCE)

    def ask(self, method, path, body=None, wanted=(200, 201, 204), **fields):
        """Status and bytes of the answer; what was not answered, or by 503 or 429, is asked again. Others than wanted are errors."""
        head = {"Class-Token": self.token} | ({"Content-Type": "application/json"} if body is not None else {}) | fields
        began, again = time.monotonic(), False
        while time.monotonic() < began + PATIENCE:
            try:
                self.line = self.line or self.open()
                self.line.request(method, (self.lesson.path or "/v1/classes") + path, None if body is None else json.dumps(body), head)
                reply = self.line.getresponse()
                data = reply.read()
                if reply.will_close:
                    self.line.close()
                    self.line = None
                if reply.status not in (429, 503):
                    with self.lesson.lock:
                        (self.lesson.late if again else self.lesson.times).append(time.monotonic() - began)
                    # what was taken away, and nobody said so, is not there when it is asked again
                    if reply.status not in wanted and not (again and method == "DELETE" and reply.status == 404):
                        self.lesson.error(f"{self.name}: {method} {path}: {reply.status} {data[:200]}")
                    return reply.status, data
                self.lesson.count(f"answers {reply.status}, asked again")
            except (OSError, http.client.HTTPException):
                self.line = None
            again = True
            time.sleep(0.05)
        self.lesson.error(f"{self.name}: {method} {path}: no answer in {PATIENCE:.0f} s")
        return 0, b""

    def join(self):
        status, data = self.ask("POST", "/pupils", {"nickname": self.name})
        number = json.loads(data)["pupil"] if status == 201 else 0
        if self.number not in (0, number):
            self.lesson.error(f"{self.name} was {self.number} and is {number}")
        self.number = number

    # --- what is heard

    def hear(self):
        cut = None
        while not self.ended.is_set():
            line = self.open()
            try:
                head = {"Class-Token": self.token} | ({"Last-Event-ID": str(self.last)} if self.last else {})
                line.request("GET", self.lesson.path + "/events", headers=head)
                reply = line.getresponse()
                if reply.status == 404:
                    self.ended.set()
                elif reply.status == 200:
                    if cut:
                        with self.lesson.lock:
                            self.lesson.resumed.append(time.monotonic() - cut)
                    self.read(reply)
                    self.lesson.count("streams cut")
                    cut = time.monotonic()
            except (OSError, http.client.HTTPException):
                cut = cut or time.monotonic()
            finally:
                line.close()
            self.ended.wait(0.05)

    def read(self, reply):
        event, number = "", 0
        while text := reply.readline():
            field, _, value = text.decode().rstrip("\n").partition(":")
            if field == "event":
                event = value.strip()
            elif field == "id":
                number = int(value)
            elif field == "data" and event == "end":
                self.ended.set()
                return
            elif field == "data":
                self.heard(number, json.loads(value))

    def heard(self, number, item):
        if number <= self.last or number != item["version"]:
            self.lesson.error(f"{self.name} heard {item['name']} of {item['version']} as {number} after {self.last}")
        self.last = number
        if item["name"] == "stages/class":
            self.arrived.append((number, time.monotonic()))
        with self.lesson.lock:
            if item["value"] is None:
                self.items.pop(item["name"], None)
            else:
                self.items[item["name"]] = (number, item["value"])

    def room(self):
        """What stands in the room for this member: {name: (version, value)}."""
        found, query = {}, ""
        while True:
            told = json.loads(self.ask("GET", query)[1])
            found |= {item["name"]: (item["version"], item["value"]) for item in told["items"] if item["value"] is not None}
            if "next" not in told:
                return found
            query = told["next"].removeprefix(self.lesson.path)

    def is_there(self, found):
        end = time.monotonic() + PATIENCE
        while self.items != found and time.monotonic() < end:
            time.sleep(0.05)
        return self.items == found


# --- pupils


def answer_to(question, dice):
    kind = question["kind"]
    if kind == "choice":
        return 1 + dice.randrange(len(question["choices"]))
    if kind == "text":
        return dice.choice(TEXTS)
    return round(dice.uniform(1, 3), 1) if "unit" in question else dice.uniform(-3, 3)


def work(pupil):
    """Does what a pupil does in a minute: looks at what is asked, answers, changes its mind, works on."""
    lesson, dice = pupil.lesson, pupil.dice
    with lesson.lock:
        standing = dict(pupil.items)
    for name, (_, question) in standing.items():
        kind, _, which = name.partition("/")
        if kind == "questions" and not question.get("closed") and (which not in pupil.kept or dice.random() < 0.1):
            value = answer_to(question, dice)
            status, _ = pupil.ask("PUT", f"/answers/{which}", {"value": value}, (200, 409))
            if status == 200:
                pupil.kept[which] = value
            lesson.count("answers accepted" if status == 200 else "answers to questions that were closed or erased meanwhile")
    if "worksheets/sheet" in standing and len(pupil.handed) < len(SHEET["steps"]):
        given = [*pupil.handed, {"step": f"step-{len(pupil.handed)}", "value": round(dice.uniform(0, 9), 3)}]
        if pupil.ask("PUT", "/handins/sheet", {"answers": given, "done": len(given) == len(SHEET["steps"])})[0] == 200:
            pupil.handed = given
    elif dice.random() < 0.5:
        pupil.ask("PUT", "/stages/own", {"scene": scene(round(dice.uniform(-3, 3), 3)), "state": dice.choice(("working", "stuck", "done"))})


def sits(pupil):
    """A pupil's lesson: it comes within two minutes, a third of them twice."""
    lesson = pupil.lesson
    lesson.over.wait(pupil.dice.uniform(0, 2) * lesson.minute)
    for _ in range(1 + (pupil.dice.random() < 0.3)):
        pupil.join()
    pupil.ear.start()
    while not lesson.over.wait(pupil.dice.uniform(0.5, 1.5) * lesson.minute):
        work(pupil)


# --- the teacher


def at_once(*acts):
    """Two tabs, the same moment."""
    gate = threading.Barrier(len(acts))
    both = [threading.Thread(target=lambda act=act: (gate.wait(), act())) for act in acts]
    for one in both:
        one.start()
    for one in both:
        one.join()


def show(lesson, teacher, everybody, body):
    """Shows something, and waits until everybody has heard of it."""
    began = time.monotonic()
    version = json.loads(teacher.ask("PUT", "/stages/class", body)[1])["version"]
    end = began + PATIENCE
    for member in everybody:
        while time.monotonic() < end and not member.ended.is_set():
            heard = [when for number, when in list(member.arrived) if number >= version]
            if heard:
                lesson.shown.append(heard[0] - began)
                break
            time.sleep(0.01)
        else:
            lesson.error(f"{member.name} did not hear of change {version}")


def first_half(lesson, tab, other, everybody):
    """Wrong scene and right one, freezing twice, a question that is erased with its answers and asked again, one erased for good."""
    swing = {"text": "How long is a swing?", "kind": "number", "unit": "s"}
    lesson.at(3)
    show(lesson, tab, everybody, {"scene": scene(9)})
    show(lesson, tab, everybody, {"scene": scene(1)})
    lesson.at(4)
    at_once(lambda: tab.ask("PUT", "/stages/class", {"scene": scene(1), "frozen": True}),
            lambda: other.ask("PUT", "/stages/class", {"scene": scene(9), "frozen": True}))
    show(lesson, tab, everybody, {"scene": scene(1), "frozen": True})
    show(lesson, other, everybody, {"scene": scene(1)})
    lesson.at(6)
    at_once(lambda: tab.ask("PUT", "/questions/swing", swing), lambda: other.ask("PUT", "/questions/swing", swing))
    lesson.at(8)
    at_once(lambda: tab.ask("DELETE", "/questions/swing", wanted=(204, 404)), lambda: other.ask("DELETE", "/questions/swing", wanted=(204, 404)),
            lambda: other_solution(lesson, other.token))
    lesson.at(10)
    tab.ask("PUT", "/questions/swing", swing)
    tab.ask("PUT", "/questions/wrong", {"text": "A question of another lesson", "kind": "choice", "choices": ["yes", "no", "both"]})
    lesson.at(13)
    at_once(lambda: tab.ask("DELETE", "/questions/wrong"), lambda: other.ask("PUT", "/questions/swing", swing | {"closed": True}))
    show(lesson, tab, everybody, {"release": {"number": 1, "spread": 0.01}})


def other_solution(lesson, token):
    Member(lesson, "the teacher's telephone", token).ask("PUT", "/solutions/swing", {"value": 2.006})


def second_half(lesson, tab, other, everybody):
    """Restarts between questions and a worksheet; what each costs."""
    lesson.at(16)
    tab.ask("PUT", "/questions/angle", {"text": "How far does it swing?", "kind": "angle"})
    tab.ask("PUT", "/worksheets/sheet", SHEET)
    troubles = [(18, "every process restarted, one after the other", lambda: [lesson.replace(i, signal.SIGTERM) for i in range(len(lesson.daemons))]),
                (22, "a process killed", lambda: lesson.replace(0, signal.SIGKILL))]
    if lesson.place.name == "postgres":
        troubles += [(26, "PostgreSQL restarted", lambda: lesson.place.restart(signal.SIGINT)), (30, "PostgreSQL crashed", lambda: lesson.place.restart(signal.SIGQUIT)),
                     (33, "PostgreSQL crashed and a process killed", lambda: (lesson.replace(1, signal.SIGKILL), lesson.place.restart(signal.SIGQUIT)))]
    for minute, name, trouble in troubles:
        lesson.at(minute)
        asks = threading.Thread(target=other.ask, args=("PUT", f"/questions/at-{minute}", {"text": "What do you see?", "kind": "text"}))
        began = time.monotonic()
        asks.start()
        trouble()
        back = time.monotonic() - began
        show(lesson, tab, everybody, {"scene": scene(minute / 10)})
        asks.join()
        print(f"  {name}: {back:.2f} s, everybody had the next scene {time.monotonic() - began - back:.2f} s later")


# --- the account


def account(lesson, tab, pupils):
    """The table against what was accepted, histograms against the table, every stream against the room."""
    rows = list(csv.DictReader(io.StringIO(tab.ask("GET", "/table")[1].decode(), newline="")))
    told = collections.defaultdict(list)
    for row in rows:
        if row["item"] in ("answers", "handins"):
            told[row["item"], row["id"], row["step"], int(row["pupil"])].append(row["value"])
    right = {("answers", which, "", pupil.number): value for pupil in pupils for which, value in pupil.kept.items()}
    right |= {("handins", "sheet", one["step"], pupil.number): one["value"] for pupil in pupils for one in pupil.handed}
    plain = lambda value: ("'" if value.startswith("=") else "") + value  # noqa: E731
    same = lambda text, value: text == plain(value) if isinstance(value, str) else float(text) == value  # noqa: E731
    wrong = [(key, told.get(key), right.get(key)) for key in right.keys() | told.keys()
             if key not in right or len(told[key]) != 1 or not same(told[key][0], right[key])]
    check("every accepted answer is in the table once, and nothing else", not wrong, str(wrong[:5]))
    check("everybody has answered and handed in", len(right) >= PUPILS * 6 and all(len(pupil.handed) == 3 for pupil in pupils), str(len(right)))
    check("no pupil has a number of another", len({pupil.number for pupil in pupils}) == PUPILS, "")
    questions = sorted({key[1] for key in told if key[0] == "answers"})
    for which in questions:
        values = [right[key] for key in right if key[:2] == ("answers", which)]
        histogram = json.loads(tab.ask("GET", f"/histograms/{which}")[1])
        counted = {one["value"]: one["count"] for one in histogram["values"]}
        binned = sum(one["count"] for one in histogram["bins"])
        inside = all(one["count"] == sum(one["from"] <= value < one["to"] or (value == one["to"] and one is histogram["bins"][-1]) for value in values)
                     for one in histogram["bins"])
        good = histogram["answers"] == len(values) and (counted == collections.Counter(values) if counted else inside and binned == len(values))
        check(f"the histogram of {which} is the table's", good, f"{histogram} {sorted(values, key=str)}")
    print(f"  {len(rows)} rows, {len(right)} answers in them, {len(questions)} histograms")


def lesson_on(build, store, directory, seconds, seed):
    lesson = Lesson(build, store, directory, 3 if store.name == "postgres" else 1, seconds / MINUTES, seed)
    with contextlib.ExitStack() as stack:
        stack.callback(lambda: [daemon.kill(signal.SIGTERM) for daemon in lesson.daemons])
        stack.callback(lesson.over.set)
        tab = Member(lesson, "the teacher")
        room = json.loads(tab.ask("POST", "", {"hours": 1}, **{"Idempotency-Key": "lesson", "Authorization": f"Bearer {tab.token}"})[1])
        lesson.path, lesson.begun = f"/v1/classes/{room['code']}", time.monotonic()
        other = Member(lesson, "the teacher's other tab", tab.token)
        pupils = [Member(lesson, f"pupil {i}") for i in range(PUPILS)]
        seats = [threading.Thread(target=sits, args=(pupil,)) for pupil in pupils]
        for one in [tab.ear, other.ear, *seats]:
            one.start()
        lesson.at(2.5)
        double = Member(lesson, "pupil 0")  # at another device, without its token: another pupil of the same name
        double.join()
        double.ear.start()
        first_half(lesson, tab, other, [tab, other, *pupils])
        work(double)
        tab.ask("DELETE", f"/pupils/{double.number}")
        second_half(lesson, tab, other, [tab, other, *pupils])
        lesson.at(MINUTES - 2)
        lesson.over.set()
        for one in seats:
            one.join()
        show(lesson, tab, [tab, other, *pupils], {"open": False})
        Member(lesson, "who is late").ask("POST", "/pupils", {"nickname": "late"}, (403,))
        check("a pupil who was sent away hears the end", double.ended.wait(PATIENCE), "")
        account(lesson, tab, pupils)
        for member in [tab, other, *pupils]:
            found = member.room()
            check(f"the stream of {member.name} has told all that stands there", member.is_there(found), f"{sorted(set(found) ^ set(member.items))}")
        tab.ask("DELETE", "")
        check("everybody hears the end", all(member.ended.wait(PATIENCE) for member in [tab, other, *pupils]), "")
        left = [lesson.place.rows(f"SELECT COUNT(*) FROM {table}")[0][0] for table in ("classes", "class_pupils", "class_items")]
        check("nothing is left of the room", left == [0, 0, 0], str(left))
    check("nobody met an error", not lesson.errors, "\n  ".join(lesson.errors[:10]))
    tell(lesson)


def tell(lesson):
    def line(what, times):
        times = sorted(1e3 * one for one in times) or [0.0]
        print(f"  {what}: {len(times)}, half within {times[len(times) // 2]:.1f} ms, p99 {times[int(0.99 * (len(times) - 1))]:.1f} ms, slowest {times[-1]:.0f} ms")

    line("answers", lesson.times)
    line("answers that met a restart", lesson.late)
    line("what was shown reached a member", lesson.shown)
    line("streams resumed", lesson.resumed)
    print("  " + ", ".join(f"{what}: {count}" for what, count in sorted(lesson.counts.items())))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("stores", nargs="*", default=["sqlite", "postgres"])
    parser.add_argument("--seconds", type=float, default=MINUTES)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    for kind in options.stores:
        if kind == "postgres" and not postgres_programs():
            skip("the lesson on PostgreSQL", "it is not installed")
            continue
        print(f"{kind}: {PUPILS} pupils, {MINUTES} minutes in {options.seconds:g} s")
        with place(kind) as store, tempfile.TemporaryDirectory(prefix="pendulumd-lesson-") as directory:
            lesson_on(TOP / options.build, store, directory, options.seconds, options.seed)
    return summary()


if __name__ == "__main__":
    sys.exit(main())
