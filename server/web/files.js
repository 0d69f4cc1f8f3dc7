// Files of the page that are loaded when they are needed: its own script, libraries and their styles.
// Leaves to others: what is said where a file does not come (its error has the kind "file").
// Invariant: a file that is refused is asked for again, under an address that was never refused, since some browsers keep a
// module's refusal; a file that came is asked for once.

const PAUSES_MS = [300, 1000, 3000];
const brought = new Map(); // path -> promise
const refusals = new Map(); // path -> how often it was refused

function addressOf(path) {
  const count = refusals.get(path);
  return new URL(count ? `${path}?again=${count}` : path, import.meta.url).href;
}

const pause = (milliseconds) =>
  new Promise((resolve) => {
    setTimeout(resolve, milliseconds);
  });

async function insist(path, load) {
  for (let tried = 0; ; tried++) {
    try {
      return await load(addressOf(path));
    } catch (error) {
      refusals.set(path, (refusals.get(path) ?? 0) + 1);
      if (tried === PAUSES_MS.length)
        throw Object.assign(new Error(`${path} did not come: ${error.message}`), { kind: "file" });
      await pause(PAUSES_MS[tried] * (1 + 0.25 * Math.random()));
    }
  }
}

/** What came once stays; what failed is tried anew by who asks next. */
function once(path, load) {
  if (!brought.has(path)) {
    const coming = insist(path, load);
    coming.catch(() => brought.delete(path));
    brought.set(path, coming);
  }
  return brought.get(path);
}

function linked(address) {
  return new Promise((resolve, reject) => {
    const link = document.createElement("link");
    link.rel = "stylesheet";
    link.href = address;
    link.onload = resolve;
    link.onerror = () => {
      link.remove();
      reject(new Error("refused"));
    };
    document.head.append(link);
  });
}

/** The module at a path below the page's directory. */
export const script = (path) => once(path, (address) => import(address));

/** Resolves when the style sheet at a path below the page's directory is in force. */
export const style = (path) => once(path, linked);
