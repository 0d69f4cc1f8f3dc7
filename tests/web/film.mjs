// A film whose truth is known: a damped pendulum as the server computes it, drawn picture by picture and put into a WebM file by
// the browser's own encoder, with times to the millisecond and no word of how long it is, as a browser's recorder leaves it.
// Leaves to others: what is measured in it (test_film.mjs).
// Invariant: each picture's time is the motion's time at which it was drawn.

export const FILM = { width: 480, height: 360, scale: 400, pivot: [236, 46], length: 0.62, damping: 0.02, theta: 38, gap: 40, count: 76, ball: 9 };

/** In the page, window.webmOf: pictures as the encoder gives them, in clusters that begin with a whole one, as a WebM file. */
const addWebm = (page) => page.evaluate(() => {
  // EBML: an element is its name, its length and its bytes
  const bytes = (value, long) => Array.from({ length: long }, (_, i) => Math.floor(value / 256 ** (long - 1 - i)) % 256);
  const element = (id, ...parts) => {
    const inner = parts.flatMap((part) => [...(typeof part === "string" ? new TextEncoder().encode(part) : part)]);
    return [...id, 0x10 + Math.floor(inner.length / 2 ** 24), ...bytes(inner.length % 2 ** 24, 3), ...inner];
  };
  window.webmOf = (clusters, width, height) => {
    const head = element([0x1a, 0x45, 0xdf, 0xa3], element([0x42, 0x82], "webm"), element([0x42, 0x87], [4]), element([0x42, 0x85], [2]));
    const info = element([0x15, 0x49, 0xa9, 0x66], element([0x2a, 0xd7, 0xb1], bytes(1e6, 3)), element([0x4d, 0x80], "test"), element([0x57, 0x41], "test"));
    const video = element([0xe0], element([0xb0], bytes(width, 2)), element([0xba], bytes(height, 2)));
    const track = element([0x16, 0x54, 0xae, 0x6b], element([0xae], element([0xd7], [1]), element([0x73, 0xc5], [1]), element([0x83], [1]), element([0x86], "V_VP8"), video));
    const blockOf = (from, { at, key, data }) => element([0xa3], [0x81, ...bytes(at - from, 2), key ? 0x80 : 0], data);
    const all = clusters.map(({ at, blocks }) => element([0x1f, 0x43, 0xb6, 0x75], element([0xe7], bytes(at, 4)), ...blocks.map((one) => blockOf(at, one))));
    const segment = [0x18, 0x53, 0x80, 0x67, 0x01, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff]; // as long as it goes on
    return new Uint8Array([...head, ...segment, ...info, ...track, ...all.flat()]);
  };
});

/** Makes the film in the page, gives it to the input and answers where the tip is: rows of [time, across, down]. */
export async function giveFilm(page, selector, { name = "swing.webm", film = FILM } = {}) {
  await addWebm(page);
  return page.evaluate(async ([made, called, to]) => {
    const { width, height, scale, pivot, length, damping, theta, gap, count, ball, tone = "#d3271d" } = made;
    const times = Array.from({ length: count }, (_, i) => i * gap / 1000);
    const { phi } = await pendulumd.client.trajectory({ pendulum: { length: [length], mass: [1], parent: [0], damping: [damping] },
      initial: { theta: [theta], unit: "deg" }, times, output: ["phi"] });
    const truth = times.map((time, i) => [time, pivot[0] + scale * length * Math.cos(phi[i][0]), pivot[1] - scale * length * Math.sin(phi[i][0])]);
    const canvas = new OffscreenCanvas(width, height);
    const paper = canvas.getContext("2d");
    const disc = (x, y, radius, colour) => { paper.fillStyle = colour; paper.beginPath(); paper.arc(x, y, radius, 0, 7); paper.fill(); };
    const draw = (x, y) => {
      for (let row = 0; row < height; row += 8) { paper.fillStyle = row % 16 ? "#8d8a83" : "#a9a294"; paper.fillRect(0, row, width, 8); }
      paper.fillStyle = "#d3271d"; paper.fillRect(8, 300, 26, 26); // something else that is red
      paper.fillStyle = "#222"; paper.fillRect(36, 338, 408, 6); // a metre: from 40 to 440
      paper.fillStyle = "#fff"; paper.fillRect(39, 334, 2, 14); paper.fillRect(439, 334, 2, 14);
      paper.strokeStyle = "#333"; paper.lineWidth = 3;
      paper.beginPath(); paper.moveTo(...pivot); paper.lineTo(x, y); paper.stroke();
      disc(...pivot, 5, "#111");
      disc(x, y, ball, tone);
    };
    const clusters = [];
    const encoder = new VideoEncoder({
      error: (error) => { throw error; },
      output: (chunk) => {
        const at = Math.round(chunk.timestamp / 1000);
        if (chunk.type === "key") clusters.push({ at, blocks: [] });
        const cluster = clusters.at(-1);
        const data = new Uint8Array(chunk.byteLength);
        chunk.copyTo(data);
        cluster.blocks.push({ at, key: chunk.type === "key", data });
      },
    });
    encoder.configure({ codec: "vp8", width, height, bitrate: 3e6, latencyMode: "quality" });
    truth.forEach(([time, x, y], i) => {
      draw(x, y);
      const frame = new VideoFrame(canvas, { timestamp: Math.round(time * 1e6) });
      encoder.encode(frame, { keyFrame: i % 25 === 0 });
      frame.close();
    });
    await encoder.flush();
    const file = new File([window.webmOf(clusters, width, height)], called, { type: "video/webm" });
    const carrier = new DataTransfer();
    carrier.items.add(file);
    const input = document.querySelector(to);
    if (input.type === "file") {
      input.files = carrier.files;
      input.dispatchEvent(new Event("change"));
    } else input.dispatchEvent(new DragEvent("drop", { dataTransfer: carrier, bubbles: true, cancelable: true }));
    return truth;
  }, [film, name, selector]);
}
