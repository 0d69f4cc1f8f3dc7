"""What clients of jobs saw, as a list of questions and answers, and whether one store that forgets nothing can have answered so.

Leaves to others: asking, and what happens meanwhile (histories.py). Invariant: the checker knows nothing but the history; what had
no answer, or a 503, promises nothing, and an answer is held against another only if it ended before the other was asked for.
"""
import collections
import threading
import time

WORDS = ("accepted", "running", "successful")  # states only go forward
OVER = ("successful", "failed", "dismissed")


class Event:
    """One question: what, of which client, with what, from when to when, and the answer.

    kind      submit: `asked` is (key, request); job, results: the id; list: None.
    status    of the answer; 0 = there was none.
    told      submit: the id; job: (status, parts done); results: the bytes; list: {id: (status, parts done)}.
    """

    def __init__(self, kind, client, asked, begin, end, status, told):
        self.kind, self.client, self.asked, self.begin, self.end, self.status, self.told = kind, client, asked, begin, end, status, told


class History:
    """Events of many threads."""

    def __init__(self):
        self.events, self.lock = [], threading.Lock()

    def ask(self, kind, client, asked, question):
        """Asks by `question`, which returns a status and what is told; the event."""
        begin = time.monotonic()
        status, told = question()
        event = Event(kind, client, asked, begin, time.monotonic(), status, told)
        with self.lock:
            self.events.append(event)
        return event


def later(events, earlier):
    """Pairs (event, what `earlier` says of all that ended before it began), for events by their begin.

    earlier  (instant, fold): folds are called in the order of their instants, before events that begin later.
    """
    folds = collections.deque(sorted(earlier, key=lambda row: row[0]))
    for event in sorted(events, key=lambda event: event.begin):
        while folds and folds[0][0] < event.begin:
            folds.popleft()[1]()
        yield event


def accepted(events):
    """Acknowledged: {id: (instant, client, request)}, and the keys that were acknowledged as two jobs, or two keys as one."""
    jobs, keys, faults = {}, {}, []
    for event in sorted((e for e in events if e.kind == "submit" and e.status in (202, 303)), key=lambda event: event.end):
        key, request = event.asked
        if keys.setdefault((event.client, key), event.told) != event.told:
            faults.append(("twice", f"key {key} of {event.client} made {keys[event.client, key]} and {event.told}"))
        if event.told in jobs and jobs[event.told][3] != (event.client, key):
            faults.append(("mixed", f"{event.told} is the job of two keys"))
        jobs.setdefault(event.told, (event.end, event.client, request, (event.client, key)))
    return jobs, faults


def seen(events):
    """Every sight of a job: (id, begin, end, status, parts done)."""
    for event in events:
        if event.status == 200 and event.kind == "job":
            yield event.asked, event.begin, event.end, *event.told
        elif event.status == 200 and event.kind == "list":
            for job, (status, done) in event.told.items():
                yield job, event.begin, event.end, status, done


def lost(events, jobs):
    """Jobs that were acknowledged and are not there, or not in their client's list."""
    for event in events:
        if event.kind in ("job", "results") and event.status == 404 and event.asked in jobs and jobs[event.asked][0] < event.begin:
            yield "lost", f"{event.asked} was acknowledged and is not known by {event.kind}"
        if event.kind == "list" and event.status == 200:
            for job, (when, client, *_) in jobs.items():
                if client == event.client and when < event.begin and job not in event.told:
                    yield "forgotten", f"{job} was acknowledged and is not in its client's list"


def backward(events):
    """Jobs whose state, or number of parts, was seen to go back; an end that changed; a state that no job here should have."""
    sights = collections.defaultdict(list)
    for job, *sight in seen(events):
        sights[job].append(sight)
    for job, all_of in sights.items():
        most, ends, faults = [-1, -1], sorted(all_of, key=lambda sight: sight[1]), []

        def fold(status, done, most=most):
            most[:] = max(most[0], WORDS.index(status)), max(most[1], done)

        good = [sight for sight in ends if sight[2] in WORDS]
        faults += [("ended", f"{job} is {sight[2]}") for sight in ends if sight[2] not in WORDS]
        events_of = [Event("job", None, job, begin, end, status, done) for begin, end, status, done in good]
        for event in later(events_of, [(e.end, lambda e=e: fold(e.status, e.told)) for e in events_of]):
            if WORDS.index(event.status) < most[0]:
                faults.append(("backward", f"{job} was {WORDS[most[0]]} and is {event.status}"))
            if event.told < most[1]:
                faults.append(("backward", f"{job} had {most[1]} parts and has {event.told}"))
        yield from faults


def results(events, jobs, right):
    """Results whose bits are not those of the request, and ends after which there are none."""
    over = {}
    for job, _, end, status, _ in seen(events):
        if status == "successful":
            over[job] = min(over.get(job, end), end)
    for event in (event for event in events if event.kind == "results"):
        if event.status == 200 and event.asked in jobs and event.told != right[jobs[event.asked][2]]:
            yield "bits", f"{event.asked}: {len(event.told)} bytes that are not its request's"
        if event.status in (202, 409) and over.get(event.asked, event.begin) < event.begin:
            yield "backward", f"{event.asked} was successful and has no results yet"


def strange(events):
    """Answers that nobody should get, whatever dies."""
    fine = {"submit": (0, 202, 303, 429, 503), "job": (0, 200, 404, 503), "results": (0, 200, 202, 404, 409, 503), "list": (0, 200, 503), "other": (0, 422, 503)}
    for event in events:
        if event.kind == "other" and event.status in (202, 303):
            yield "reused", f"key {event.asked[0]} of {event.client} was acknowledged, and takes another request: it was forgotten"
        elif event.status not in fine[event.kind]:
            yield "strange", f"{event.kind} {event.asked} was answered {event.status}: {event.told!r:.200}"


def check(events, right):
    """Every fault of a history: (kind, sentence).

    right  {request: the bits of its results}.
    """
    jobs, faults = accepted(events)
    for found in (lost(events, jobs), backward(events), results(events, jobs, right), strange(events)):
        faults += found
    return faults


# --- the checker itself: a history that is fine, and one with a fault of each kind

def fine():
    """Two clients, three jobs; one submission is repeated, one question overlaps the change that it asks for."""
    return [
        Event("submit", "a", ("k1", "map"), 0, 9, 0, None), Event("submit", "a", ("k1", "map"), 1, 2, 202, "j1"),
        Event("submit", "a", ("k1", "map"), 3, 4, 202, "j1"), Event("submit", "b", ("k1", "walk"), 1, 5, 202, "j2"),
        Event("submit", "a", ("k2", "walk"), 6, 20, 202, "j3"), Event("other", "a", ("k1", "walk"), 6, 7, 422, None),
        Event("job", "a", "j1", 5, 6, 200, ("running", 1)), Event("job", "a", "j1", 6, 9, 200, ("successful", 3)),
        Event("job", "a", "j1", 7, 8, 200, ("running", 2)), Event("job", "a", "j3", 10, 11, 404, None),
        Event("list", "a", None, 10, 12, 200, {"j1": ("successful", 3)}), Event("list", "b", None, 10, 12, 200, {"j2": ("accepted", 0)}),
        Event("results", "a", "j1", 13, 14, 200, b"m"), Event("results", "b", "j2", 13, 14, 503, None)]


FAULTS = {
    "twice": Event("submit", "a", ("k1", "map"), 15, 16, 202, "j9"),
    "mixed": Event("submit", "b", ("k7", "map"), 15, 16, 202, "j1"),
    "lost": Event("job", "a", "j1", 15, 16, 404, None),
    "forgotten": Event("list", "b", None, 15, 16, 200, {}),
    "backward": Event("job", "a", "j1", 15, 16, 200, ("running", 3)),
    "ended": Event("job", "b", "j2", 15, 16, 200, ("failed", 0)),
    "bits": Event("results", "b", "j2", 15, 16, 200, b"m"),
    "reused": Event("other", "a", ("k1", "walk"), 15, 16, 202, "j8"),
    "strange": Event("list", "a", None, 15, 16, 500, None),
}
MORE = (Event("list", "a", None, 15, 16, 200, {"j1": ("successful", 2)}), Event("results", "a", "j1", 15, 16, 409, None))


def sound():
    """Does the checker find nothing where there is nothing, and each fault where it is? What it does not."""
    right = {"map": b"m", "walk": b"w"}
    wrong = [f"a fine history has {fault}" for fault in check(fine(), right)]
    for kind, event in [*FAULTS.items(), *(("backward", event) for event in MORE)]:
        found = {fault[0] for fault in check(fine() + [event], right)}
        if found != {kind}:
            wrong.append(f"a history that is {kind} is told as {found}")
    return wrong
