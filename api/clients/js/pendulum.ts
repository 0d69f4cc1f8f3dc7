// Planar pendulum trees from a pendulumd server, in browsers and Node.js 18 or later, without a dependency.
//
//     import { Pendulum } from "pendulumd";
//     const pendulum = new Pendulum({ length: [1, 1], mass: [1, 1], parent: [0, 1] });
//     const motion = await pendulum.run({ initial: { theta: [2, 2.5] }, times: { stop: 5, step: 0.01 } });
//
// Leaves to others: the types of fields (openapi.ts, generated from the server's OpenAPI document); other fields are sent to
// the server as `more`. Invariant: an incomplete answer is never returned as if it were complete.
import type { components } from "./openapi.js";

type Schemas = components["schemas"];
/** The fields of a route's request besides the pendulum. */
type Without<T> = T extends unknown ? Omit<T, "pendulum"> : never;

export type Tree = Schemas["Pendulum"];
export type State = Schemas["State"];
export type Times = Schemas["Times"];
export type EnsembleRequest = Without<Schemas["EnsembleRequest"]>;
export type Output = NonNullable<Schemas["TrajectoryRequest"]["output"]>[number];
export type Trajectory = Schemas["Trajectory"];
export type Job = Schemas["Job"];
/** The numbers in rows: doubles, or floats of 4 bytes. */
export type NumberKind = Schemas["NumberKind"];
/** Any other fields, such as those of a later version of the server. */
export type More = Record<string, unknown>;

type Default = "phi" | "phid" | "lambda";
export type MotionRequest<O extends Output = Output> = Omit<Schemas["TrajectoryRequest"], "pendulum" | "output"> & { output?: O[] };
/** A trajectory with the requested outputs. */
export type Motion<O extends Output> = Omit<Trajectory, O> & Required<Pick<Trajectory, O>>;
type Column<O extends Output> = O extends "z" | "zd" ? `${O}_re` | `${O}_im` : O extends "energy" ? never : O;
type Energies<O extends Output> = "energy" extends O ? "energy_kinetic" | "energy_potential" | "energy_total" : never;
/** One instant: arrays with a number per arm, as views of the received bytes. */
export type Row<O extends Output, N extends NumberKind = "float64"> =
  { t: number } & { [K in Column<O>]: N extends "float32" ? Float32Array : Float64Array } & { [K in Energies<O>]: number };

/** The requests of the routes besides the pendulum, and their answers. */
export interface Routes {
  trees: { request: object; answer: Schemas["Tree"] };
  trajectories: { request: MotionRequest; answer: Trajectory };
  forces: { request: Without<Schemas["ForcesRequest"]>; answer: Schemas["Forces"] };
  modes: { request: Without<Schemas["ModesRequest"]>; answer: Schemas["Modes"] };
  ensembles: { request: EnsembleRequest; answer: Schemas["Ensemble"] };
  lyapunov: { request: Without<Schemas["LyapunovRequest"]>; answer: Schemas["Lyapunov"] };
  sections: { request: Without<Schemas["SectionRequest"]>; answer: Schemas["Section"] };
  response: { request: Without<Schemas["ResponseRequest"]>; answer: Schemas["FrequencyResponse"] };
  controllers: { request: Without<Schemas["ControllerRequest"]>; answer: Schemas["ControllerDesign"] };
  tables: { request: Without<Schemas["TableRequest"]>; answer: Schemas["Tables"] };
  trials: { request: Schemas["TrialsRequest"]; answer: Schemas["Trials"] };
  fits: { request: Without<Schemas["FitRequest"]>; answer: Schemas["Fit"] };
  orbits: { request: Without<Schemas["OrbitRequest"]>; answer: Schemas["Orbits"] };
  equations: { request: Without<Schemas["EquationsRequest"]>; answer: Schemas["Equations"] };
}

/** The server refused a request; `problem.errors` names every fault. */
export class Refusal extends Error {
  override readonly name = "Refusal";

  constructor(readonly status: number, readonly problem: Partial<Schemas["Problem"]>) {
    super([`${status} ${problem.detail ?? ""}`, ...(problem.errors ?? []).map((fault) => `  ${fault.pointer} ${fault.detail}`)].join("\n"));
  }
}

export interface Options {
  /** Address of the server; PENDULUM_URL, or in a browser the origin of the page. */
  url?: string;
  /** The client's own secret, which lists and ends jobs; PENDULUM_TOKEN, or none. */
  token?: string;
  /** Longest time, s, for which temporary refusals and broken connections are retried without receiving anything. */
  patience?: number;
  /** Aborts the running requests and their computations on the server; jobs continue until `cancel`. */
  signal?: AbortSignal;
}

const environment = (globalThis as { process?: { env: Record<string, string | undefined> } }).process?.env ?? {};
const TRANSIENT = [429, 502, 503, 504];
/** Servers that have answered: these may come back, while a server that never answered has a wrong address. */
const met = new Set<string>();
const ROWS = "application/x-ndjson"; // its last line has the warnings, which others send in trailers that fetch cannot read
const WHERE = "set its address by PENDULUM_URL or the option url";

/** A server. */
export class Client {
  readonly url: string;
  readonly patience: number;
  private readonly fields: Record<string, string>;
  private readonly signal: AbortSignal | null;

  constructor(options: Options = {}) {
    const page = typeof location === "undefined" ? "http://127.0.0.1:8080" : location.origin;
    this.url = (options.url || environment["PENDULUM_URL"] || page).replace(/\/+$/, "");
    this.patience = options.patience ?? 60;
    this.signal = options.signal ?? null;
    const token = options.token || environment["PENDULUM_TOKEN"];
    this.fields = token ? { Authorization: `Bearer ${token}` } : {};
  }

  /** fetch that is aborted by the signal. Node.js 18's own loses its signal if garbage is collected while it waits. */
  private async fetched(url: string, init: RequestInit): Promise<Response> {
    const signal = this.signal;
    if (!signal) return fetch(url, init);
    let abort = (): void => {};
    const gone = new Promise<never>((_, no) => {
      abort = () => no(signal.reason);
      signal.addEventListener("abort", abort);
    });
    try {
      return await Promise.race([fetch(url, init), gone]);
    } finally {
      signal.removeEventListener("abort", abort);
    }
  }

  /** Returns an answer with a status below 400 or in `good`; retries while the server refuses temporarily. */
  async open(method: string, path: string, fields: Record<string, string> = {}, body?: unknown, good: number[] = []): Promise<Response> {
    const end = performance.now() + 1000 * this.patience;
    const init = {
      method, signal: this.signal, headers: { ...this.fields, ...fields, ...(body === undefined ? {} : { "Content-Type": "application/json" }) },
      ...(body === undefined ? {} : { body: JSON.stringify(body, plain) }),
    };
    for (let pause = 0.1; ; pause = Math.min(2 * pause, 5)) {
      let wait = pause;
      let refusal: unknown;
      try {
        const response = await this.fetched(this.url + path, init);
        met.add(this.url);
        const page = response.headers.get("Content-Type")?.startsWith("text/html");
        if (page && !TRANSIENT.includes(response.status))
          throw refusal = new Refusal(response.status, { detail: `${this.url} answers with a web page, so it is not pendulumd: ${WHERE}` });
        if (response.ok || good.includes(response.status)) return response;
        const text = await response.text();
        const told = problem(text);
        if (response.status === 401 && !this.fields["Authorization"]) told.detail += ". Set PENDULUM_TOKEN, or the option token, before the job is submitted.";
        refusal = new Refusal(response.status, told);
        if (!TRANSIENT.includes(response.status)) throw refusal;
        const after = response.headers.get("Retry-After") ?? "";
        wait = Math.max(wait, Number(after) || (Date.parse(after) - Date.now()) / 1000 || 0);
      } catch (error) {
        if (error === refusal || this.signal?.aborted) throw error;
        if (!met.has(this.url) && !cut(error)) throw new Error(`no server at ${this.url} (${reason(error)}): ${WHERE}`, { cause: error });
        refusal = error;
      }
      if (performance.now() + 1000 * wait > end) throw refusal;
      await sleep(wait);
    }
  }

  /** Returns the JSON at a path, or the answer to a body; an answer that breaks off is requested once more. */
  async json<T>(method: string, path: string, body?: unknown, fields: Record<string, string> = {}): Promise<T> {
    for (let last = false; ; last = true) {
      const response = await this.open(method, path, { Accept: "application/json", ...fields }, body);
      try {
        return await response.json();
      } catch (error) {
        if (last || this.signal?.aborted) throw error;
      }
    }
  }

  get presets(): Promise<Schemas["PresetList"]> {
    return this.json("GET", "/v1/presets");
  }

  /** Returns a job by its id. */
  job<T = unknown>(id: string): JobHandle<T> {
    return new JobHandle<T>(this, id);
  }

  /** Returns your jobs that match the filter, the newest first; needs a token. */
  async *jobs(which: { status?: Job["status"]; operation?: string; title?: string; since?: string } = {}): AsyncGenerator<Job> {
    for (let path: string | undefined = `/v1/jobs?${new URLSearchParams(Object.entries({ limit: "100", ...which }).filter((pair): pair is [string, string] => pair[1] !== undefined))}`; path; ) {
      const page: Schemas["JobList"] = await this.json("GET", path);
      yield* page.jobs;
      path = page.links.find((link) => link.rel === "next")?.href;
    }
  }
}

/** A pendulum tree. */
export class Pendulum {
  readonly client: Client;

  /** more: fields of the pendulum that are not in the OpenAPI document. */
  constructor(readonly tree: Tree, options: Options | Client = {}, readonly more: More = {}) {
    this.client = options instanceof Client ? options : new Client(options);
  }

  private body(fields: object, more: More): { pendulum: object; number?: unknown } {
    return { pendulum: { ...this.tree, ...this.more }, ...fields, ...more };
  }

  /** Any route. more: fields that are not in the OpenAPI document. */
  ask<R extends keyof Routes>(route: R, fields: Routes[R]["request"], more: More = {}): Promise<Routes[R]["answer"]> {
    return this.client.json("POST", `/v1/${route}`, this.body(fields, more));
  }

  /** The motion as arrays: motion.phi[i][k] of instant i and arm k. */
  run<O extends Output = Default>(fields: MotionRequest<O>, more: More = {}): Promise<Motion<O>> {
    return this.client.json("POST", "/v1/trajectories", this.body(fields, more));
  }

  /** Yields the motion, of any length, instant by instant while it is computed. Warnings go to console.warn at its end; the generator returns them with the stats. */
  async *rows<O extends Output = Default, N extends NumberKind = "float64">(fields: MotionRequest<O> & { number?: N }, more: More = {}): AsyncGenerator<Row<O, N>, RowsEnd> {
    const accept = { Accept: ROWS };
    const body = this.body(fields, more);
    return yield* rowsOf<Row<O, N>>(await this.client.open("POST", "/v1/trajectories", accept, body), body.number);
  }

  /** Submits a request as a job. key: the same key returns the same job. title: its name in lists. more: fields that are not in the OpenAPI document. */
  async submit<R extends keyof Routes>(route: R, fields: Routes[R]["request"], options: { key?: string; title?: string; more?: More } = {}): Promise<JobHandle<Routes[R]["answer"]>> {
    const { key, title, more = {} } = options;
    // unique among this client's keys; it need not be hard to guess, and Node.js 18 has no global crypto
    const own = key ?? [Date.now(), Math.random(), Math.random()].map((part) => part.toString(36).replace("0.", "")).join("-");
    const job: Job = await this.client.json("POST", `/v1/${route}`, this.body(fields, more), { Prefer: "respond-async", "Idempotency-Key": own, ...(title ? { "Job-Title": encodeURIComponent(title) } : {}) });
    if (!job.id) throw new Refusal(501, { detail: "this server stores no jobs" });
    return new JobHandle(this.client, job.id);
  }
}

/** A request that the server computes in the background; T is the type of its answer. */
export class JobHandle<T> {
  constructor(readonly client: Client, readonly id: string) {}

  state(): Promise<Job> {
    return this.client.json("GET", `/v1/jobs/${this.id}`);
  }

  /** Yields the job's state at each poll until it has ended. */
  async *progress(): AsyncGenerator<Job> {
    for (let pause = 0.01; ; pause = Math.min(1.5 * pause, 1)) {
      const state = await this.state();
      yield state;
      if (!["accepted", "running"].includes(state.status)) return;
      await sleep(pause);
    }
  }

  private async ended(): Promise<void> {
    let state: Job | undefined;
    for await (state of this.progress());
    if (state?.status !== "successful") throw new Refusal(409, { detail: `the job ${this.id} is ${state?.status}: ${state?.message}` });
  }

  /** Waits for the end and returns the answer. */
  async result(): Promise<T> {
    return JSON.parse(new TextDecoder().decode(await this.bytes("application/json")));
  }

  /** Waits for the end and returns the results in any format; a download that breaks off is resumed. */
  async bytes(accept: string): Promise<Uint8Array<ArrayBuffer>> {
    await this.ended();
    const pieces: Uint8Array[] = [];
    let [have, etag, end] = [0, "", performance.now() + 1000 * this.client.patience];
    for (;;) {
      const range: Record<string, string> = have ? { Range: `bytes=${have}-`, "If-Range": etag } : {};
      const response = await this.client.open("GET", `/v1/jobs/${this.id}/results`, { Accept: accept, ...range }, undefined, [416]);
      if (response.status === 416 && response.headers.get("Content-Range") === `bytes */${have}`) return joined(pieces, have);
      if (response.status !== 206) [pieces.length, have] = [0, 0]; // the whole: what is there is of another answer
      if (response.status === 416) continue;
      etag = response.headers.get("ETag") ?? "";
      try {
        for await (const piece of chunks(response)) {
          pieces.push(piece);
          have += piece.length;
          end = performance.now() + 1000 * this.client.patience;
        }
        return joined(pieces, have);
      } catch (error) {
        if (performance.now() > end || !(error instanceof TypeError)) throw error;
        await sleep(0.1);
      }
    }
  }

  /** Waits for the end and yields the results, of any length, row by row: floats if its request had `number: "float32"`. */
  async *rows<R = Record<string, number | Float32Array | Float64Array>>(): AsyncGenerator<R, RowsEnd> {
    await this.ended();
    const { number }: { number?: unknown } = await this.client.json("GET", `/v1/jobs/${this.id}/request`);
    return yield* rowsOf<R>(await this.client.open("GET", `/v1/jobs/${this.id}/results`, { Accept: ROWS }), number);
  }

  cancel(): Promise<Job> {
    return this.client.json("DELETE", `/v1/jobs/${this.id}`);
  }
}

/** Sends typed arrays as lists; refuses numbers that JSON cannot contain. */
function plain(name: string, value: unknown): unknown {
  if (typeof value === "number" && !Number.isFinite(value)) throw new TypeError(`${name} is ${value}: numbers of a request must be finite`);
  return ArrayBuffer.isView(value) && !(value instanceof DataView) ? Array.from(value as unknown as ArrayLike<number>) : value;
}

function sleep(seconds: number): Promise<void> {
  return new Promise((resolve) => setTimeout(resolve, 1000 * seconds));
}

/** Returns the reason of a failed fetch; browsers tell little. */
function reason(error: unknown): string {
  const { cause } = error as { cause?: { code?: string; message?: string } };
  return cause?.message || cause?.code || String(error);
}

/** Whether a server answered and its connection broke. */
function cut(error: unknown): boolean {
  return ["ECONNRESET", "EPIPE", "UND_ERR_SOCKET"].includes((error as { cause?: { code?: string } }).cause?.code ?? "");
}

function problem(text: string): Partial<Schemas["Problem"]> {
  try {
    return JSON.parse(text);
  } catch {
    return { detail: text.slice(0, 500) };
  }
}

function joined(pieces: Uint8Array[], size: number): Uint8Array<ArrayBuffer> {
  const whole = new Uint8Array(size);
  let at = 0;
  for (const piece of pieces) {
    whole.set(piece, at);
    at += piece.length;
  }
  return whole;
}

async function* chunks(response: Response): AsyncGenerator<Uint8Array> {
  const reader = response.body?.getReader();
  if (!reader) return;
  try {
    for (let got = await reader.read(); !got.done; got = await reader.read()) yield got.value;
  } finally {
    await reader.cancel();
  }
}

/** The last line of an application/x-ndjson answer, about all rows. */
export interface RowsEnd {
  stats?: Record<string, unknown>;
  /** Also written by console.warn, because `for await` drops the value that a generator returns. */
  warnings: string[];
}

/**
 * Yields the rows of an application/x-ndjson answer; parts of columns have their own names: `energy_total`, `z_re`. A TypeError if it
 * breaks off. number: the type of arrays; float32 rounds each number to the nearest float. null, the time of no event, becomes NaN.
 */
export async function* rowsOf<R>(response: Response, number: unknown = "float64"): AsyncGenerator<R, RowsEnd> {
  const Numbers = number === "float32" ? Float32Array : Float64Array;
  const one = number === "float32" ? Math.fround : (value: number) => value;
  const numbers = (value: unknown) => {
    if (!Array.isArray(value)) return one((value as number | null) ?? NaN);
    const view = new Numbers(value.length);
    for (let k = 0; k < view.length; k++) view[k] = value[k] ?? NaN;
    return view;
  };
  const decoder = new TextDecoder();
  let rest = "";
  for await (const chunk of chunks(response)) {
    const lines = (rest + decoder.decode(chunk, { stream: true })).split("\n");
    rest = lines.pop() ?? "";
    for (const text of lines) {
      const line: Record<string, unknown> = JSON.parse(text);
      if (line["problem"]) {
        const problem = line["problem"] as Schemas["Problem"];
        throw new Refusal(problem.status, problem);
      }
      if (line["stats"]) {
        const { stats, warnings = [] } = line as { stats: Record<string, unknown>; warnings?: string[] };
        for (const warning of warnings) console.warn(`pendulum: ${warning}`);
        return { stats, warnings };
      }
      const row: Record<string, number | Float32Array | Float64Array> = {};
      for (const name in line) {
        const value = line[name];
        if (value === null || typeof value !== "object" || Array.isArray(value)) row[name] = numbers(value);
        else for (const [part, inner] of Object.entries(value)) row[`${name}_${part}`] = numbers(inner);
      }
      yield row as R;
    }
  }
  throw new TypeError("the answer was cut off");
}
