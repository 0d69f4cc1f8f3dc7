// The stage as a film: what its canvas shows is recorded while it moves, and saved.
// Leaves to others: the motion, the browser's encoder.
// Invariant: what cannot be recorded here is said, not hidden.

import { button, save } from "../kit/kit.js";

const KINDS = ["video/mp4", "video/webm;codecs=vp9", "video/webm"];
const FRAMES = 30; // a second

/** A button that begins and ends it. @param {App} app @param {HTMLElement} status */
export function recordButton({ text, clock }, status) {
  /** @type {MediaRecorder | null} */
  let recorder = null;
  const begin = () => {
    const canvas = /** @type {HTMLCanvasElement | null} */ (
      document.querySelector("#stage canvas")
    );
    const kind = KINDS.find((type) => window.MediaRecorder?.isTypeSupported(type));
    if (!canvas?.captureStream || !kind) {
      status.textContent = text("measure.noFilm");
      return;
    }
    const stream = canvas.captureStream(FRAMES);
    recorder = new MediaRecorder(stream, { mimeType: kind });
    /** @type {Blob[]} */
    const pieces = [];
    recorder.addEventListener("dataavailable", ({ data }) => pieces.push(data));
    recorder.addEventListener("stop", () => {
      const name = `pendulum.${kind.slice(6, 10).replace(";", "")}`;
      for (const track of stream.getTracks()) track.stop();
      save(new Blob(pieces, { type: kind }), name);
      status.textContent = text("plots.saved", { name });
    });
    recorder.start();
    clock.play();
    key.textContent = text("measure.filmStop");
    status.textContent = text("measure.filming");
  };
  const end = () => {
    recorder?.stop();
    recorder = null;
    key.textContent = text("measure.film");
  };
  const key = button(text("measure.film"), () => (recorder ? end() : begin()), {
    "data-film": "record",
  });
  return { element: key, destroy: () => recorder && end() };
}
