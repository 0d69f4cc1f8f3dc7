// The only clock of the page: stage, plots and thumbnails follow it.
// Leaves to others: what there is to see at a time (motion.js).
// Invariant: 0 <= time <= available <= duration; while it plays, subscribers are called once a
// frame, and never while the page is hidden: it goes on from where it was.

/**
 * What keeps the clock going: the frame that is asked for, when the last one was, where to go on
 * once there is data.
 * @typedef {{clock: Clock, listeners: Set<(clock: Clock) => unknown>, frame: number, last: number,
 * goal: number}} Works
 */

/** @param {Works} works */
function tell({ clock, listeners }) {
  for (const listener of listeners) listener(clock);
}

/** @param {Works} works */
function schedule(works) {
  if (!works.frame && works.clock.playing && !document.hidden)
    works.frame = requestAnimationFrame((now) => tick(works, now));
}

/** @param {Works} works @param {number} now milliseconds */
function tick(works, now) {
  works.frame = 0;
  if (!works.clock.playing) return;
  // a page that was hidden goes on from where it was
  const passed = works.last ? Math.min(Math.max(now - works.last, 0) / 1000, 0.1) : 0;
  works.last = now;
  advance(works, passed * works.clock.speed);
  schedule(works);
  works.clock.framing = true;
  tell(works);
  works.clock.framing = false;
}

/** @param {Works} works @param {number} seconds */
function advance({ clock, goal }, seconds) {
  const next = clock.time + seconds;
  // on the way to where it was before
  clock.waiting = goal > 0;
  if (clock.waiting) return;
  if (next <= clock.available) {
    clock.time = next;
  } else if (!clock.complete) {
    clock.time = clock.available;
    clock.waiting = true;
  } else if (clock.loop && clock.available > 0) {
    clock.time = next % clock.available;
  } else {
    clock.time = clock.available;
    clock.playing = false;
  }
}

/** The page has gone out of sight, or come back. @param {Works} works */
function turn(works) {
  cancelAnimationFrame(works.frame);
  works.frame = 0;
  works.last = 0;
  schedule(works);
}

/** @param {Works} works */
function play(works) {
  const { clock } = works;
  if (clock.playing) return;
  if (clock.complete && clock.time >= clock.available) clock.time = 0;
  clock.playing = true;
  // the first frame shows what has passed since
  works.last = performance.now();
  schedule(works);
  tell(works);
}

/** @param {Works} works */
function pause(works) {
  const { clock } = works;
  if (!clock.playing) return;
  clock.playing = false;
  clock.waiting = false;
  cancelAnimationFrame(works.frame);
  works.frame = 0;
  tell(works);
}

/**
 * @param {Works} works @param {number} available @param {number} duration @param {boolean} complete
 */
function extent(works, available, duration, complete) {
  const { clock, goal } = works;
  clock.available = available;
  clock.duration = duration;
  clock.complete = complete;
  if (goal && available >= Math.min(goal, duration)) {
    clock.time = Math.min(goal, duration);
    works.goal = 0;
  }
  if (clock.time > available) clock.time = available;
  tell(works);
}

const STILL = {
  time: 0,
  playing: false,
  framing: false, // it tells of a frame that is being made
  waiting: false, // it plays, but the data for the next instant is not here yet
  speed: 1,
  loop: true,
  duration: 0,
  available: 0, // up to where there is data
  complete: false, // no more data will come
};

/** @returns {Clock} */
export function createClock() {
  const works = /** @type {Works} */ ({ listeners: new Set(), frame: 0, last: 0, goal: 0 });
  /** @type {Clock} */
  const clock = {
    ...STILL,
    play: () => play(works),
    pause: () => pause(works),
    toggle: () => (clock.playing ? pause(works) : play(works)),
    seek(time) {
      clock.time = Math.min(Math.max(time, 0), clock.available);
      works.goal = 0;
      works.last = 0;
      tell(works);
    },
    /** How far the data reaches, of how much there will be. */
    extent: (available, duration, complete) => extent(works, available, duration, complete),
    /** Other data will come: begins at 0, and goes on at `time` once that is there. */
    restart(time = 0) {
      clock.time = 0;
      works.goal = time;
      works.last = performance.now();
    },
    /** The same instant has another number: what follows counts from so many seconds on. */
    shift(seconds) {
      clock.time = Math.max(0, clock.time - seconds);
      works.goal = 0;
    },
    setSpeed(speed) {
      clock.speed = speed;
      tell(works);
    },
    setLoop(loop) {
      clock.loop = loop;
      tell(works);
    },
    /** fn(clock) at every change; answers what ends it. */
    subscribe(fn) {
      works.listeners.add(fn);
      return () => works.listeners.delete(fn);
    },
  };
  works.clock = clock;
  document.addEventListener("visibilitychange", () => turn(works));
  return clock;
}
