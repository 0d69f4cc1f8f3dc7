// Draws a pendulum on a canvas: arms in the colours of their forces, tips, trails, ghosts.
// Leaves to others: where the tips are (tree.js), what is chosen, when to draw.
// Invariant: drawing a frame allocates nothing but what the canvas does; arms of one colour are one path.

const BINS = 49; // odd: the middle one is no force
const MIDDLE = (BINS - 1) / 2;
const ARROW = 120; // pixels of the force at the end of the scale

const names = {
  safe: ["--tension", "--no-force", "--compression"],
  paper: ["--paper-tension", "--no-force", "--paper-compression"],
};

function mix(a, b, share) {
  return a.map((value, i) => Math.round(value + share * (b[i] - value)));
}

function rgb(hex) {
  const digits = hex.trim().slice(1);
  return [0, 2, 4].map((i) => parseInt(digits.slice(i, i + 2), 16));
}

const GHOSTS = [4, 3, 5, 7, 6, 8]; // of the arms' colours, those least like tension and compression first

/** The property that holds the colour of the `i`th ghost, on the stage and wherever it is marked. */
export const ghostColour = (i) => `--arm-${GHOSTS[i % GHOSTS.length]}`;

/** The colours of the page's style, as a canvas takes them; made anew when the theme or the palette changes. */
export function readColours(palette) {
  const style = getComputedStyle(document.documentElement);
  const value = (name) => style.getPropertyValue(name).trim();
  const [low, none, high] = names[palette].map((name) => rgb(value(name)));
  const bins = Array.from({ length: BINS }, (_, i) => {
    const share = (i - MIDDLE) / MIDDLE;
    // soon away from grey, so that small forces show their sign
    const strong = Math.sqrt(Math.abs(share));
    return `rgb(${mix(none, share < 0 ? low : high, strong).join(",")})`;
  });
  return {
    bins,
    font: `13px ${getComputedStyle(document.body).fontFamily}`,
    ink: value("--ink"),
    quiet: value("--quiet"),
    glass: value("--glass"),
    accent: value("--accent"),
    paper: value("--stage"),
    mass: value("--mass"),
    ghosts: GHOSTS.map((_, i) => value(ghostColour(i))),
    trails: [1, 2, 3, 4, 5].map((i) => value(`--trail-${i}`)),
  };
}

/** The colour's place, 0 ... BINS-1, of a force, `most` being the end of the scale. */
export function bin(force, most) {
  const share = most > 0 ? Math.max(-1, Math.min(1, force / most)) : 0;
  return Math.round(MIDDLE + share * MIDDLE);
}

/** How wide an arm is drawn, in pixels: wider with its force. */
const width = (i, thin) => thin * (1 + (1.9 * Math.abs(i - MIDDLE)) / MIDDLE);

/** Radius of a tip in pixels: by its mass, but a short arm is not to vanish behind it. */
function tipRadius(tree, k, heaviest, camera, thin) {
  const wanted = Math.max(thin * 1.1, thin * 3 * Math.cbrt(tree.mass[k] / heaviest));
  return Math.max(0.6, Math.min(wanted, 0.35 * camera.scale * tree.length[k]));
}

/** Adds an arrow of so many pixels to the path. */
function arrow(context, x, y, dx, dy, pixels) {
  const head = Math.min(9, 3 + pixels * 0.2);
  const tx = x + dx * pixels;
  const ty = y + dy * pixels;
  context.moveTo(x, y);
  context.lineTo(tx, ty);
  context.moveTo(tx - head * (dx + 0.55 * dy), ty - head * (dy - 0.55 * dx));
  context.lineTo(tx, ty);
  context.lineTo(tx - head * (dx - 0.55 * dy), ty - head * (dy + 0.55 * dx));
}

/** A rectangle with round ends. */
function pill(context, x, y, width, height) {
  const r = height / 2;
  context.arc(x + r, y + r, r, Math.PI / 2, 1.5 * Math.PI);
  context.arc(x + width - r, y + r, r, 1.5 * Math.PI, 0.5 * Math.PI);
}

/** A painter for trees of up to n arms. */
export function createPainter(context) {
  let heads = new Int32Array(BINS);
  let next = new Int32Array(0);

  /** Chains the arms of every colour, in place. */
  function sort(forces, most, n) {
    if (next.length < n) next = new Int32Array(n);
    heads.fill(-1);
    for (let k = n - 1; k >= 0; k--) {
      const i = bin(forces[k], most);
      next[k] = heads[i];
      heads[i] = k;
    }
  }

  return {
    /** camera: {x, y, scale}, the pivot in pixels and pixels a metre. */
    arms(tree, x, y, forces, most, camera, colours, thin) {
      const n = tree.length.length;
      sort(forces, most, n);
      context.lineCap = "round";
      for (let i = 0; i < BINS; i++) {
        if (heads[i] < 0) continue;
        context.beginPath();
        for (let k = heads[i]; k >= 0; k = next[k]) {
          const carrier = tree.parent[k];
          context.moveTo(
            camera.x + camera.scale * (carrier ? x[carrier - 1] : 0),
            camera.y - camera.scale * (carrier ? y[carrier - 1] : 0),
          );
          context.lineTo(camera.x + camera.scale * x[k], camera.y - camera.scale * y[k]);
        }
        context.strokeStyle = colours.bins[i];
        context.lineWidth = width(i, thin);
        context.stroke();
      }
    },

    tips(tree, x, y, heaviest, camera, colours, thin) {
      let outlined = false;
      context.beginPath();
      for (let k = 0; k < tree.length.length; k++) {
        const px = camera.x + camera.scale * x[k];
        const py = camera.y - camera.scale * y[k];
        const r = tipRadius(tree, k, heaviest, camera, thin);
        outlined ||= r > 3;
        context.moveTo(px + r, py);
        context.arc(px, py, r, 0, 2 * Math.PI);
      }
      context.fillStyle = colours.mass;
      context.fill();
      if (!outlined) return;
      context.lineWidth = Math.max(1, thin * 0.5);
      context.strokeStyle = colours.paper;
      context.stroke();
    },

    /** What the pendulum hangs on. */
    pivot(camera, colours) {
      const half = 22;
      const up = camera.y - 9;
      context.strokeStyle = colours.quiet;
      context.fillStyle = colours.paper;
      context.lineCap = "round";
      context.lineWidth = 1.6;
      context.beginPath();
      context.moveTo(camera.x - half, up);
      context.lineTo(camera.x + half, up);
      context.moveTo(camera.x - 8, up);
      context.lineTo(camera.x, camera.y);
      context.lineTo(camera.x + 8, up);
      context.stroke();
      context.beginPath();
      context.arc(camera.x, camera.y, 4, 0, 2 * Math.PI);
      context.fill();
      context.stroke();
    },

    /** At every tip the force that its arm pushes it with. */
    arrows(tree, x, y, phi, forces, most, camera, colours) {
      if (!(most > 0)) return;
      for (let sign = -1; sign <= 1; sign += 2) {
        context.beginPath();
        for (let k = 0; k < tree.length.length; k++) {
          if (forces[k] * sign <= most * 0.01) continue;
          arrow(
            context,
            camera.x + camera.scale * x[k],
            camera.y - camera.scale * y[k],
            Math.cos(phi[k]) * sign,
            -Math.sin(phi[k]) * sign,
            ARROW * Math.min(1.5, (forces[k] * sign) / most),
          );
        }
        context.strokeStyle = colours.bins[sign < 0 ? 0 : BINS - 1];
        context.lineWidth = 2;
        context.lineCap = "round";
        context.lineJoin = "round";
        context.stroke();
      }
    },

    /** Around the tip of the arm that is chosen, or under the hand. */
    ring(arm, shape, camera, colours, strong) {
      const k = arm - 1;
      context.beginPath();
      context.arc(
        camera.x + camera.scale * shape.x[k],
        camera.y - camera.scale * shape.y[k],
        tipRadius(shape.tree, k, shape.heaviest, camera, shape.thin) + 5,
        0,
        2 * Math.PI,
      );
      context.strokeStyle = colours.accent;
      context.lineWidth = strong ? 3.5 : 2;
      context.stroke();
    },

    /** Words beside a tip, where they hide the fewest other tips. */
    label(words, arm, shape, camera, colours, across) {
      context.font = colours.font;
      const wide = context.measureText(words).width + 20;
      const px = camera.x + camera.scale * shape.x[arm - 1];
      const py = camera.y - camera.scale * shape.y[arm - 1];
      let best = null;
      for (const [x, y] of [
        [px + 16, py - 13],
        [px - 16 - wide, py - 13],
        [px - wide / 2, py - 44],
        [px - wide / 2, py + 18],
      ]) {
        let hidden = x < 4 || x + wide > across - 4 ? 50 : 0;
        for (let k = 0; k < shape.n; k++) {
          const dx = camera.x + camera.scale * shape.x[k] - x;
          const dy = camera.y - camera.scale * shape.y[k] - y;
          if (dx > -8 && dx < wide + 8 && dy > -8 && dy < 34) hidden++;
          // the middle of the arm
          const carrier = shape.tree.parent[k];
          const mx = dx - (camera.scale * (shape.x[k] - (carrier ? shape.x[carrier - 1] : 0))) / 2;
          const my = dy + (camera.scale * (shape.y[k] - (carrier ? shape.y[carrier - 1] : 0))) / 2;
          if (mx > -4 && mx < wide + 4 && my > -4 && my < 30) hidden += 0.5;
        }
        if (!best || hidden < best.hidden) best = { x, y, hidden };
      }
      context.beginPath();
      pill(context, best.x, best.y, wide, 26);
      context.fillStyle = colours.glass;
      context.fill();
      context.textBaseline = "middle";
      context.textAlign = "left";
      context.fillStyle = colours.ink;
      context.fillText(words, best.x + 10, best.y + 14);
    },

    /** Thin and pale: another motion of the same pendulum, the `i`th. */
    ghost(i, tree, x, y, camera, colours, thin) {
      context.beginPath();
      for (let k = 0; k < tree.length.length; k++) {
        const carrier = tree.parent[k];
        context.moveTo(
          camera.x + camera.scale * (carrier ? x[carrier - 1] : 0),
          camera.y - camera.scale * (carrier ? y[carrier - 1] : 0),
        );
        context.lineTo(camera.x + camera.scale * x[k], camera.y - camera.scale * y[k]);
      }
      context.strokeStyle = colours.ghosts[i % colours.ghosts.length];
      context.lineWidth = thin;
      context.globalAlpha = 0.65;
      context.stroke();
      context.globalAlpha = 1;
    },
  };
}
