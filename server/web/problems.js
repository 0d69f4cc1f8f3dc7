// What has failed, and what the server refuses, in the language of the page: the interface speaks
// English.
// Leaves to others: what fails (client.js).
// Invariant: English has the server's own words; the other languages name the field and what is
// wrong with it by the request's pointer, and no English word where the pointer is known.

/** What the page calls the fields of requests. @type {Record<string, string>} */
const FIELDS = {
  length: "arm.length",
  mass: "arm.mass",
  phi: "arm.angle",
  theta: "arm.angle",
  phid: "arm.rate",
  thetad: "arm.rate",
  gravity: "arm.gravity",
  method: "drawer.method",
  rtol: "step.tolerance",
  atol: "step.tolerance",
  title: "step.title",
  times: "time.scrub",
  stop: "time.scrub",
  step: "time.scrub",
  duration: "time.scrub",
  damping: "physics.damping",
  friction: "physics.dry",
  stiffness: "physics.stiffness",
};

/** What is wrong, by the server's words. @type {[RegExp, string][]} */
const WRONGS = [
  [/limit [\w-]+ of ([\d.e+]+)/, "problem.limit"],
  [/greater than 0\b/, "arm.wrong.positive"],
  [/./, "problem.value"],
];

/**
 * The field of a pointer, "/pendulum/mass/1", in words.
 * @param {string} pointer @param {Text} text
 */
function fieldOf(pointer, text) {
  const parts = pointer.split("/").slice(1);
  const name = parts.findLast((part) => part in FIELDS && text.has(FIELDS[part]));
  if (!name) return pointer || "/";
  const what = text(FIELDS[name]);
  const arm = parts.findLast((part) => /^\d+$/.test(part));
  return arm ? text("problem.arm", { what, arm: Number(arm) + 1 }) : what;
}

/** @param {{pointer?: string, detail: string}} fault @param {Text} text */
function faultOf({ pointer = "", detail }, text) {
  const what = fieldOf(pointer, text);
  if (text.language === "en" || what === (pointer || "/")) return `${what}: ${detail}`;
  const [shape, key] = WRONGS.find(([one]) => one.test(detail)) ?? WRONGS[WRONGS.length - 1];
  return text(key, { what, most: shape.exec(detail)?.[1] });
}

/**
 * A refusal in words.
 * @param {number} status @param {Problem | null} problem @param {Text} text
 */
function refusal(status, problem, text) {
  const faults = problem?.errors ?? [];
  if (faults.length) return faults.map((fault) => faultOf(fault, text)).join("; ");
  const known = text.has(`problem.${status}`) ? `problem.${status}` : "failure.refused";
  if (problem?.detail && text.language === "en") return problem.detail;
  return text(known, { status });
}

/** A failure in words. @param {any} failure @param {Text} text */
export function failed(failure, text) {
  if (failure.kind !== "refused")
    return text(`failure.${failure.kind}`, { status: failure.status });
  return refusal(failure.status, failure.problem, text);
}
