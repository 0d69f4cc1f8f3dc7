// The map of flips: for every start of two arms, when an arm first turns over; a point of it is a start.
// Leaves to others: the computing (the server's ensembles, asked strip by strip so that the map grows).
// Invariant: a point's colour is the server's number; a point that is clicked starts from the angles of its middle, all else as when the map was computed.

import { createBag, h } from "../dom.js";
import { said } from "../client.js";
import { still, theme } from "../theme.js";
import { aborted, button, choice, cssValue, fetchTable, figure, later, save } from "./kit.js";

const SIZES = [60, 120, 240];
const DURATIONS = [5, 10, 20];
const STRIP = 2400; // motions a request, about
const DEGREE = Math.PI / 180;
const HANGING = -Math.PI / 2;
const MARGIN = { left: 48, bottom: 40, top: 8, right: 10 };
// even steps in lightness for every kind of colour vision (viridis)
const SHADES = [
  [68, 1, 84],
  [71, 44, 122],
  [59, 81, 139],
  [44, 113, 142],
  [33, 144, 141],
  [39, 173, 129],
  [92, 200, 99],
  [170, 220, 50],
  [253, 231, 37],
];

export function shade(share) {
  const at = Math.max(0, Math.min(1, share)) * (SHADES.length - 1);
  const i = Math.min(Math.floor(at), SHADES.length - 2);
  return SHADES[i].map((from, c) => Math.round(from + (at - i) * (SHADES[i + 1][c] - from)));
}

/** The angle of place i of `count` from -180 to 180 degrees, as the server counts it. */
const angleAt = (i, count) => -180 + (360 * i) / (count - 1);

export function mountFlipMap(app) {
  const { store, clock, client, text } = app;
  const bag = createBag();
  const canvas = h("canvas", {
    class: "map",
    tabindex: 0,
    role: "application",
    "aria-label": text("compare.mapLabel"),
    "aria-describedby": "map-point",
  });
  const point = h("p", { class: "map-point", id: "map-point", role: "status" });
  const status = h("p", { class: "quiet", role: "status" });
  const bar = h("progress", { max: 1, value: 0, hidden: true, "aria-label": text("compare.map") });
  const context = canvas.getContext("2d");
  const place = h("div", { hidden: true }, canvas, point);
  const controls = h("div", { class: "row" });
  let map = null; // {pendulum, initial, across, up, count, duration, times, arms, status, done}
  let picture = null; // the map's points, one pixel each
  let cross = { i: 0, j: 0 };
  let stop = null;
  let size = { width: 0, height: 0 };
  const wish = { across: 1, up: 2, count: 120, duration: 10 };

  const compute = button(text("compare.compute"), () => (stop ? stop.abort() : run()), {
    class: "button main",
    "data-map": "compute",
  });
  const png = button(text("compare.savePng"), savePng, { hidden: true, "data-map": "png" });

  function controlsFor(arms) {
    const armList = Array.from({ length: arms }, (_, k) => ({
      value: k + 1,
      words: String(k + 1),
    }));
    wish.across = Math.min(wish.across, arms);
    if (wish.up > arms || wish.up === wish.across) wish.up = wish.across === arms ? 1 : arms;
    const pick = (key, label, options) => {
      const made = choice(label, options, wish[key], (value) => {
        wish[key] = Number(value);
      });
      made.select.dataset.map = key;
      return made.element;
    };
    controls.replaceChildren(
      pick("across", text("compare.across"), armList),
      pick("up", text("compare.up"), armList),
      pick(
        "count",
        text("compare.points"),
        SIZES.map((value) => ({ value, words: text("compare.pointsValue", { count: value }) })),
      ),
      pick(
        "duration",
        text("compare.duration"),
        DURATIONS.map((value) => ({ value, words: text("compare.seconds", { time: value }) })),
      ),
      compute,
      png,
    );
    compute.disabled = arms < 2;
    if (arms < 2) status.textContent = text("compare.mapOne");
  }

  const axis = (arm, from, to, count) => ({
    vary: "theta",
    arm,
    start: from,
    stop: to,
    count,
    unit: "deg",
  });

  /** Of rows `row` ... row + rows - 1 from below; all of them without. */
  function bodyOf({ pendulum, initial, across, up, count, duration }, row = 0, rows = count) {
    const { length, mass, parent, gravity } = pendulum;
    return {
      pendulum: { length, mass, parent, gravity },
      initial: { phi: initial.phi, phid: initial.phid },
      grid: [
        axis(across, -180, 180, count),
        axis(up, angleAt(row, count), angleAt(row + rows - 1, count), rows),
      ],
      duration,
      observables: ["first_flip"],
    };
  }

  async function run() {
    if (wish.across === wish.up) wish.up = wish.across === 1 ? 2 : 1;
    controlsFor(store.get().pendulum.length.length);
    const { pendulum, initial } = store.get();
    const { count } = wish;
    map = {
      pendulum,
      initial,
      ...wish,
      times: new Float64Array(count * count).fill(NaN),
      arms: new Uint16Array(count * count),
      failed: new Uint8Array(count * count),
      done: 0,
    };
    const mine = map;
    picture = h("canvas", { width: count, height: count });
    stop = new AbortController();
    cross = startCross();
    compute.textContent = text("compare.stop");
    place.hidden = bar.hidden = false;
    png.hidden = true;
    fit();
    try {
      const rows = Math.max(1, Math.round(STRIP / count));
      for (let row = 0; row < count; row += rows) {
        const many = Math.min(rows, count - row);
        take(
          mine,
          row,
          await fetchTable(client, "/v1/ensembles", bodyOf(mine, row, many), {
            signal: stop.signal,
          }),
        );
      }
      status.textContent = text("compare.done", { count: count * count });
      app.announce(status.textContent);
      png.hidden = false;
    } catch (error) {
      status.textContent = aborted(error) ? text("compare.stopped") : said(error, text);
    }
    stop = null;
    bar.hidden = true;
    compute.textContent = text("compare.compute");
    draw();
  }

  function take(mine, row, { columns, count }) {
    const from = row * mine.count;
    mine.times.set(columns.first_flip_time.subarray(0, count), from);
    mine.arms.set(columns.first_flip_arm.subarray(0, count), from);
    mine.failed.set(columns.status.subarray(0, count), from);
    mine.done = from + count;
    const all = mine.count ** 2;
    bar.value = mine.done / all;
    status.textContent = text("compare.progress", {
      percent: Math.floor((100 * mine.done) / all),
      count: all,
    });
    paint();
    draw();
  }

  /** The scale: from the earliest flip there is to the duration, by logarithms. */
  function earliest() {
    let least = map.duration;
    for (const time of map.times) if (time > 0 && time < least) least = time;
    return Math.max(least, map.duration / 100);
  }

  function paint() {
    const { count, times, failed } = map;
    const image = new ImageData(count, count);
    const low = Math.log(earliest());
    const high = Math.log(map.duration);
    const never = theme.dark ? [31, 36, 45] : [255, 255, 255];
    for (let i = 0; i < map.done; i++) {
      const to = 4 * ((count - 1 - Math.floor(i / count)) * count + (i % count));
      const colour = failed[i]
        ? [128, 128, 128]
        : times[i] < 0
          ? never
          : shade((Math.log(Math.max(times[i], 1e-9)) - low) / (high - low));
      image.data.set(colour, to);
      image.data[to + 3] = 255;
    }
    picture.getContext("2d").putImageData(image, 0, 0);
  }

  function fit() {
    const width = Math.min(place.clientWidth, 520);
    if (!width) return;
    const ratio = Math.min(devicePixelRatio, 2);
    const side = width - MARGIN.left - MARGIN.right;
    size = { side, width, height: side + MARGIN.top + MARGIN.bottom + 54, ratio };
    canvas.width = width * ratio;
    canvas.height = size.height * ratio;
    canvas.style.width = `${width}px`;
    canvas.style.height = `${size.height}px`;
    draw();
  }

  /** Pixels of the middle of place (i, j). */
  const middle = (i, j) => ({
    x: MARGIN.left + ((i + 0.5) / map.count) * size.side,
    y: MARGIN.top + ((map.count - 0.5 - j) / map.count) * size.side,
  });

  function axesWithNames() {
    const bottom = MARGIN.top + size.side;
    context.fillStyle = cssValue("--quiet");
    context.font = "11px system-ui, sans-serif";
    context.textAlign = "center";
    const at = (angle) => ((angle + 180) / 360) * size.side;
    for (const angle of [-180, -90, 0, 90, 180]) {
      context.textAlign = angle === 180 ? "right" : angle === -180 ? "left" : "center";
      context.fillText(`${text.short(angle)}\u00b0`, MARGIN.left + at(angle), bottom + 14);
      context.textAlign = "right";
      context.fillText(
        `${text.short(angle)}\u00b0`,
        MARGIN.left - 5,
        Math.max(bottom - at(angle) + 4, MARGIN.top + 9),
      );
    }
    context.textAlign = "center";
    context.fillText(
      text("compare.axisX", { arm: map.across }),
      MARGIN.left + size.side / 2,
      bottom + 30,
    );
    context.save();
    context.translate(10, MARGIN.top + size.side / 2);
    context.rotate(-Math.PI / 2);
    context.fillText(text("compare.axisY", { arm: map.up }), 0, 0);
    context.restore();
  }

  function scaleWithTicks() {
    const low = earliest();
    const y = MARGIN.top + size.side + MARGIN.bottom;
    const wide = size.side - 70;
    for (let x = 0; x < wide; x++) {
      context.fillStyle = `rgb(${shade(x / wide).join(",")})`;
      context.fillRect(MARGIN.left + x, y, 1.5, 9);
    }
    context.fillStyle = cssValue("--quiet");
    context.textAlign = "center";
    const ticks = [0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20].filter(
      (time) => time >= low && time <= map.duration,
    );
    const at = (time) => MARGIN.left + (Math.log(time / low) / Math.log(map.duration / low)) * wide;
    for (const time of ticks) context.fillText(text.short(time), at(time), y + 24);
    // every digit has its stroke, which shows that the scale is one of logarithms
    for (const power of [0.01, 0.1, 1, 10]) {
      for (let digit = 1; digit < 10; digit++) {
        const time = digit * power;
        if (time >= low && time <= map.duration)
          context.fillRect(at(time) - 0.5, y + 9, 1, ticks.includes(time) ? 5 : 3);
      }
    }
    context.fillText(text("compare.neverShort"), MARGIN.left + wide + 42, y + 24);
    context.textAlign = "left";
    context.fillText(text("compare.scale"), MARGIN.left, y + 40);
    context.strokeStyle = cssValue("--quiet");
    context.lineWidth = 1;
    context.strokeRect(MARGIN.left + wide + 32.5, y + 0.5, 20, 8);
  }

  function draw() {
    if (!map || !size.width) return;
    context.setTransform(size.ratio, 0, 0, size.ratio, 0, 0);
    context.clearRect(0, 0, size.width, size.height);
    context.imageSmoothingEnabled = false;
    context.drawImage(picture, MARGIN.left, MARGIN.top, size.side, size.side);
    context.strokeStyle = cssValue("--line");
    context.strokeRect(MARGIN.left - 0.5, MARGIN.top - 0.5, size.side + 1, size.side + 1);
    axesWithNames();
    scaleWithTicks();
    const { x, y } = middle(cross.i, cross.j);
    for (const [colour, width] of [
      ["#000", 3.5],
      ["#fff", 1.5],
    ]) {
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.beginPath();
      context.arc(x, y, 6, 0, 2 * Math.PI);
      context.moveTo(x - 11, y);
      context.lineTo(x - 6, y);
      context.moveTo(x + 6, y);
      context.lineTo(x + 11, y);
      context.stroke();
    }
    outdated();
  }

  function outdated() {
    if (map.pendulum !== store.get().pendulum && !stop)
      status.textContent = text("compare.outdated");
  }

  /** The place nearest to the start that the stage has. */
  function startCross() {
    const { initial } = store.get();
    const near = (arm) => {
      const angle = (initial.phi[arm - 1] - HANGING) / DEGREE;
      const inside = ((((angle + 180) % 360) + 360) % 360) - 180;
      return Math.max(
        0,
        Math.min(map.count - 1, Math.round(((inside + 180) / 360) * (map.count - 1))),
      );
    };
    return { i: near(map.across), j: near(map.up) };
  }

  function whatAt({ i, j }) {
    const at = j * map.count + i;
    if (at >= map.done) return text("compare.unknown");
    if (map.failed[at]) return text("compare.failed");
    if (map.times[at] < 0) return text("compare.never", { time: text.short(map.duration) });
    return text("compare.flips", { arm: map.arms[at], time: figure(text, map.times[at], 3) });
  }

  function describe(where) {
    point.textContent = text("compare.point", {
      a: map.across,
      b: map.up,
      x: text.number(angleAt(where.i, map.count), 1),
      y: text.number(angleAt(where.j, map.count), 1),
      what: whatAt(where),
    });
  }

  function start(where) {
    if (map.pendulum !== store.get().pendulum) return outdated();
    cross = where;
    const phi = [...map.initial.phi];
    phi[map.across - 1] = HANGING + angleAt(where.i, map.count) * DEGREE;
    phi[map.up - 1] = HANGING + angleAt(where.j, map.count) * DEGREE;
    store.set({ initial: { phi, phid: map.initial.phid } }, { label: "flipmap" });
    clock.seek(0);
    if (!still.matches) clock.play();
    describe(where);
    draw();
  }

  function placeOf(event) {
    const box = canvas.getBoundingClientRect();
    const i = Math.floor(((event.clientX - box.left - MARGIN.left) / size.side) * map.count);
    const j =
      map.count - 1 - Math.floor(((event.clientY - box.top - MARGIN.top) / size.side) * map.count);
    return i >= 0 && j >= 0 && i < map.count && j < map.count ? { i, j } : null;
  }

  const MOVES = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };
  bag.on(canvas, "keydown", (event) => {
    if (!map) return;
    if (event.key === "Enter") {
      event.preventDefault();
      start(cross);
      return;
    }
    const move = MOVES[event.key];
    if (!move) return;
    event.preventDefault();
    event.stopPropagation();
    const far = event.shiftKey ? 10 : 1;
    const within = (value) => Math.max(0, Math.min(map.count - 1, value));
    cross = { i: within(cross.i + far * move[0]), j: within(cross.j + far * move[1]) };
    describe(cross);
    draw();
  });
  bag.on(canvas, "click", (event) => {
    const where = map && placeOf(event);
    if (where) start(where);
  });
  bag.on(canvas, "mousemove", (event) => {
    const where = map && placeOf(event);
    if (where) describe(where);
    canvas.style.cursor = where ? "crosshair" : "default";
  });

  async function savePng() {
    try {
      const { blob } = await client.file(
        "/v1/ensembles",
        { ...bodyOf(map), picture: { of: "first_flip", scale: "log" } },
        "image/png",
      );
      save(blob, "flips.png");
    } catch (error) {
      if (!aborted(error)) status.textContent = said(error, text);
    }
  }

  const observer = new ResizeObserver(later(fit));
  observer.observe(place);
  bag(() => observer.disconnect());
  bag(theme.subscribe(() => map && (paint(), draw())));
  bag(
    store.subscribe((doc, before) => {
      if (doc.pendulum !== before.pendulum) controlsFor(doc.pendulum.length.length);
      if (map && doc.pendulum !== before.pendulum) outdated();
    }),
  );
  controlsFor(store.get().pendulum.length.length);

  const element = h(
    "section",
    { "aria-label": text("compare.map") },
    h("h3", {}, text("compare.map")),
    h("p", { class: "quiet" }, text("compare.mapIntro")),
    controls,
    bar,
    status,
    place,
  );
  return {
    element,
    show: fit,
    hide() {},
    destroy() {
      stop?.abort();
      bag.end();
    },
  };
}
