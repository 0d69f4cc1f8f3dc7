// The only clock of the page: stage, plots and thumbnails follow it.
// Leaves to others: what there is to see at a time (motion.js).
// Invariant: 0 <= time <= available <= duration; while it plays, subscribers are called once a frame.

export function createClock() {
  const listeners = new Set();
  let frame = 0;
  let last = 0;
  let goal = 0; // where to go on once there is data

  const clock = {
    time: 0,
    playing: false,
    waiting: false, // it plays, but the data for the next instant is not here yet
    speed: 1,
    loop: true,
    duration: 0,
    available: 0, // up to where there is data
    complete: false, // no more data will come

    play() {
      if (clock.playing) return;
      if (clock.complete && clock.time >= clock.available) clock.time = 0;
      clock.playing = true;
      last = 0;
      schedule();
      tell();
    },
    pause() {
      if (!clock.playing) return;
      clock.playing = false;
      clock.waiting = false;
      cancelAnimationFrame(frame);
      frame = 0;
      tell();
    },
    toggle() {
      clock.playing ? clock.pause() : clock.play();
    },
    seek(time) {
      clock.time = Math.min(Math.max(time, 0), clock.available);
      goal = 0;
      last = 0;
      tell();
    },
    /** How far the data reaches, of how much there will be. */
    extent(available, duration, complete) {
      clock.available = available;
      clock.duration = duration;
      clock.complete = complete;
      if (goal && available >= Math.min(goal, duration)) {
        clock.time = Math.min(goal, duration);
        goal = 0;
      }
      if (clock.time > available) clock.time = available;
      tell();
    },
    /** Other data will come: begins at 0, and goes on at `time` once that is there. */
    restart(time = 0) {
      clock.time = 0;
      goal = time;
      last = 0;
    },
    setSpeed(speed) {
      clock.speed = speed;
      tell();
    },
    setLoop(loop) {
      clock.loop = loop;
      tell();
    },
    /** fn(clock) at every change; answers what ends it. */
    subscribe(fn) {
      listeners.add(fn);
      return () => listeners.delete(fn);
    },
  };

  function tell() {
    for (const listener of listeners) listener(clock);
  }

  function schedule() {
    if (!frame && clock.playing) frame = requestAnimationFrame(tick);
  }

  function tick(now) {
    frame = 0;
    if (!clock.playing) return;
    // a page that was hidden goes on from where it was
    const passed = last ? Math.min((now - last) / 1000, 0.1) : 0;
    last = now;
    advance(passed * clock.speed);
    schedule();
    tell();
  }

  function advance(seconds) {
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

  return clock;
}
