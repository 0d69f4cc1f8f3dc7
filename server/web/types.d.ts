// The shapes that the page's modules hand each other, named once: for readers, and for tsc, which
// checks every module of the page against them (tests/rules/types.sh).
// Leaves to others: what is done with them. Nothing here is part of a bundle.
// Invariant: angles are radians, 0 is to the right, they grow against the clock; metres, kilograms,
// seconds, newtons.

/** A place on an arm, m: along it, or [along, across]. */
type Place2 = number | number[];

interface Body {
    mass: number;
    center: Place2;
    inertia?: number;
}

/** amplitude cos(omega t + phase) */
interface Harmonic {
    amplitude: number;
    omega: number;
    phase?: number;
}

/** A pivot on a rail, m, kg, N: its place is along the rail, at an angle to the right. */
interface Cart {
    mass: number;
    angle?: number;
    damping?: number;
    stiffness?: number;
    force?: number | { constant?: number; harmonics?: Harmonic[] };
}

/** Stops of a joint, rad. */
interface Stop {
    min?: number;
    max?: number;
    restitution?: number;
}

/** A torque at instants, N m, linear between them or held. */
interface TorqueTable {
    t: number[];
    value: number[];
    hold: "zero" | "linear";
    outside?: "hold" | "zero";
}

/** Places of a pivot at instants, m, with a natural spline through them. */
type PlaceTable = Pick<TorqueTable, "t" | "value">;

interface Axis {
    harmonics?: Harmonic[];
    table?: PlaceTable;
}

/** What a real pendulum has beyond an ideal one, as requests have it: one entry an arm. */
interface Terms {
    rod?: (number | null)[];
    body?: (Body | null)[];
    at?: (Place2 | null)[];
    damping?: (number | null)[];
    stiffness?: (number | null)[];
    rest?: (number | null)[];
    friction?: ({ torque: number; static?: number; speed?: number } | null)[];
    torque?: (number | { constant?: number; harmonics?: Harmonic[]; table?: TorqueTable } | null)[];
    stop?: (Stop | null)[];
    drag?: ({ linear?: number; quadratic?: number; speed?: number } | null)[];
    drag_per_mass?: number;
    pivot?: { x?: Axis; y?: Axis; acceleration?: number[]; cart?: Cart };
    control?: object[];
}

/** Arms are numbered from 1; parent[k - 1] is the arm that carries arm k, 0 is the pivot. */
interface Tree extends Terms {
    length: number[];
    mass: number[];
    parent: number[];
    gravity: number;
}

/** Angles and angular velocities of all arms; of a pendulum on a cart its place and speed. */
interface State {
    phi: number[];
    phid: number[];
    cart?: { x: number; v: number };
}

/**
 * Another start beside the document's, or (apart) the document's own with its first arm turned by
 * so much.
 */
interface Ghost extends State {
    /** Of the same arms as the document's, with other numbers; the document's where it is left out. */
    pendulum?: Tree;
    /** A second pendulum, drawn to the right (1) or to the left (-1) of the document's. */
    beside?: number;
    apart?: number;
    method?: string;
    rtol?: number | null;
    atol?: number | null;
}

interface View {
    drawer: string | null;
    speed: number;
    loop: boolean;
    trails: number[];
    arrows: boolean;
    /** Arrows at the tips: names of VECTORS (paint_vectors.js), and how long they are. */
    vectors: string[];
    vectorScale: number;
    /** The motion goes on at its end. */
    endless: boolean;
    /** [x, y] of both ends, m from the pivot; nothing in it: it is not laid down yet. */
    ruler: number[] | null;
    /** [x, y] of its corner, m; its legs, degrees from hanging, counterclockwise. */
    protractor: number[] | null;
    palette: string;
    selected: number;
}

/** What the page shows: one immutable object. */
interface Doc {
    title: string;
    preset: string | null;
    pendulum: Tree;
    initial: State;
    /** From `start` (0 where it is left out) for `stop` seconds. */
    span: { start?: number; stop: number; step: number };
    method: string;
    rtol: number | null;
    atol: number | null;
    precision: string;
    ghosts: Ghost[];
    view: View;
}

/** What changes of a document; `view` may name only some of its keys. */
type Patch = Partial<Omit<Doc, "view">> & { view?: Partial<View> };

interface Cause {
    label: string;
    merge?: string | null;
}

type Listener = (doc: Doc, before: Doc, cause: Cause) => unknown;
/** Ends what has been begun. */
type End = () => unknown;

interface Store {
    get(): Doc;
    set(patch: Patch, options?: { label?: string; merge?: string | null }): void;
    settle(): void;
    refuse(fn: (() => unknown) | null): void;
    undo(): string | null;
    redo(): string | null;
    canUndo(): boolean;
    canRedo(): boolean;
    subscribe(fn: Listener): End;
}

/** The body of /v1/trajectories, and of what is asked for like it. */
interface MotionBody {
    pendulum: Terms & {
        length: number[];
        mass?: (number | null)[];
        parent: number[];
        gravity?: number;
    };
    initial: State;
    times: { start?: number; stop: number; step?: number; count?: number };
    method?: string;
    rtol?: number | null;
    atol?: number | null;
    precision?: string;
    output?: string[];
}

/**
 * How an integration went; of a motion that is sent while it is computed only part of it is known.
 */
interface Stats {
    horizon?: number; // not of method linear
    energy_drift?: number;
    warnings?: string | null;
    trust_until?: number;
    steps?: number;
    rejected?: number;
    evaluations?: number;
    compute_seconds?: number;
}

interface Column {
    name: string;
    count: number;
}

type Columns = Record<string, Float64Array>;

/**
 * The least that a motion of which pictures are drawn has: rows 0 ... count - 1 of phi and phid.
 */
interface Samples {
    doc: { pendulum: Tree; span: { start?: number; step: number } };
    initial: State;
    n: number;
    count: number;
    columns: Columns;
}

/** One trajectory: a table of samples from the server, row by row. */
interface Track extends Samples {
    doc: Doc;
    total: number;
    complete: boolean;
    preview: ArrayLike<number> | null;
    t: Float64Array;
    widths: Record<string, number>;
    parts: { values: Float64Array; count: number; offset: number; shift: number }[];
    width: number;
    stats: Stats | null;
}

/** Where a time lies among samples. */
interface Place {
    index: number;
    fraction: number;
}

interface Instant extends Place {
    time: number;
    phi: Float64Array;
    phid: Float64Array;
    lambda: Float64Array;
    cart: number;
}

interface Failed extends Error {
    kind: string;
    status: number;
    problem: Problem | null;
    retry: number;
}

interface Problem {
    detail?: string;
    reachable?: boolean; // false: a proxy says that its server is gone
    errors?: { pointer?: string; detail: string }[];
}

interface Motion {
    track: Track;
    ghosts: Track[];
    stats: Stats | null;
    loading: boolean;
    failure: Failed | null;
    complaint: string | null;
    readonly t: Float64Array;
    readonly columns: Columns;
    readonly n: number;
    readonly count: number;
    readonly total: number;
    readonly complete: boolean;
    readonly doc: Doc;
    readonly held: boolean;
    at(time: number): Instant;
    hold(): void;
    proceed(row: number): void;
    exchange(ghost: number): void;
    foresee(lambda: ArrayLike<number>): void;
    release(): void;
    reload(): Promise<void>;
    note(words: string | null): void;
    begin(): Promise<void>;
    subscribe(fn: (motion: Motion, what: string) => unknown): End;
}

interface Clock {
    time: number;
    playing: boolean;
    framing: boolean;
    waiting: boolean;
    speed: number;
    loop: boolean;
    duration: number;
    available: number;
    complete: boolean;
    play(): void;
    pause(): void;
    toggle(): void;
    seek(time: number): void;
    extent(available: number, duration: number, complete: boolean): void;
    restart(time?: number): void;
    shift(seconds: number): void;
    setSpeed(speed: number): void;
    setLoop(loop: boolean): void;
    subscribe(fn: (clock: Clock) => unknown): End;
}

interface AskOptions {
    signal?: AbortSignal;
}

interface TableOptions extends AskOptions {
    begin(columns: Column[], stats: Stats | null): unknown;
    rows(values: Float64Array, count: number): unknown;
    reply?: Response | null;
}

/** Answers are the server's JSON, whose shape api/openapi.yaml tells. */
type Answer = Promise<any>;

interface Client {
    readonly state: { kind: string; retry: number };
    hurry(): void;
    readonly engine: Engine;
    watch(fn: (state: { kind: string; retry: number }) => unknown): End;
    /** longest: between two tries, s. */
    ask(path: string, options?: RequestInit, longest?: number): Promise<Response>;
    post(path: string, body: object, options?: AskOptions & { accept?: string }): Promise<Response>;
    trajectory(body: object, options?: AskOptions): Answer;
    forces(body: object, options?: AskOptions): Answer;
    modes(body: object, options?: AskOptions): Answer;
    trees(body: object, options?: AskOptions): Answer;
    tables(body: object, options?: AskOptions): Answer;
    trials(body: object, options?: AskOptions): Answer;
    ensembles(body: object, options?: AskOptions): Answer;
    equations(body: object, options?: AskOptions): Answer;
    storeScene(body: object, options?: AskOptions): Answer;
    scene(id: string, options?: AskOptions): Answer;
    presets(options?: AskOptions): Answer;
    preset(name: string, options?: AskOptions): Answer;
    file(
        path: string,
        body: object,
        accept: string,
        options?: AskOptions,
    ): Promise<{ blob: Blob; name: string }>;
    table(path: string, body: object, options: TableOptions): Promise<void>;
}

/** text(key, holes), and numbers as the language writes them. */
interface Text {
    (key: string, holes?: Record<string, unknown>): string;
    language: string;
    /** The language that the address names or that was chosen here; "" without such a choice. */
    chosen(): string;
    said(failure: any): string;
    has(key: string): boolean;
    /** By the language's plural: the key's .one, .other ...; {count} is filled in. */
    count(key: string, count: number, holes?: Record<string, unknown>): string;
    /** Resolves when the words of a part (text/LANGUAGE/PART.js) are here. */
    part(name: string): Promise<void>;
    number(value: number, digits?: number): string;
    short(value: number, digits?: number): string;
    read(typed: string): number;
    /** Resolves when the page's words are those of the language: the reader's without one. */
    use(language?: string): Promise<void>;
}

interface Edits {
    readonly grabbed: boolean;
    grab(): void;
    release(seconds?: number): void;
    cancel(): void;
    turn(arm: number, angle: number, length?: number | null): void;
    angle(arm: number): number;
    setLength(arm: number, length: number, merge?: string | null): void;
    setMass(arm: number, mass: number, merge?: string | null): void;
    lengthen(arm: number, by: number): void;
    weigh(arm: number, factor: number): void;
    setGravity(gravity: number): void;
    setStart(arm: number, name: "phi" | "phid", value: number): void;
    add(carrier: number): void;
    remove(arm: number): void;
    resize(count: number): void;
    trail(arm: number): void;
    select(arm: number): void;
    addBeside(): void;
    swap(): void;
    begin(): void;
}

/** Changes of the pendulum while it moves (live.js). */
interface Live {
    change(name: string, change: (tree: Tree, time: number) => Tree): void;
    waiting(): number;
}

interface Theme {
    readonly dark: boolean;
    toggle(): void;
    paper(on: boolean): void;
    subscribe(fn: () => unknown): End;
}

/** Files that are loaded when they are needed; a script is whatever it exports. */
interface Files {
    script(path: string): Promise<any>;
    style(path: string): Promise<unknown>;
}

/** The page without a server (offline.js). */
interface Offline {
    /** "none", "coming" or "kept" */
    readonly kind: string;
    readonly newer: boolean;
    begin(): Promise<void>;
    check(): Promise<void>;
    speak(): void;
    watch(fn: () => unknown): End;
}

/** What every view knows. */
interface App {
    store: Store;
    motion: Motion;
    clock: Clock;
    client: Client;
    offline: Offline;
    text: Text;
    theme: Theme;
    files: Files;
    /** What was made in this browser (journal.js). */
    yours: {
        list(): import("./journal.js").Entry[];
        keep(list: import("./journal.js").Entry[]): void;
        patch(entry: import("./journal.js").Entry): Patch | null;
    };
    edits: Edits;
    live: Live;
    announce(words: string): void;
    object(words: string): void;
    complain(words: string): void;
    print(): Promise<void>;
    undo(): void;
    redo(): void;
    speak(language: string): Promise<void>;
    /** The stage's: opens the fields of an arm. */
    editArm(arm: number): void;
    stage: {
        /** other: of the second pendulum beside the document's. */
        tip(arm: number, other?: boolean): Point;
        camera: Camera;
        seen(): Seen;
        join(part: StagePart): End;
    };
    /** Whose table a fit is of: the film that was marked (drawers/film/film.js). */
    film?: { fitted(table: string, camera: FitCamera): number | null } | null;
    /** The film that was there before another language was. */
    shot?: Shot | null;
    /** The table and the fit that were there before another language was (drawers/fits/fits.js). */
    fitting?: Fitting | null;
    /** The rows of the table of trials (drawers/measure/trials.js). */
    trials?: Record<string, number>[];
    /** A table that waits for the drawer Measure (drawers/fits/measurements.js). */
    measurements?: string | null;
}

/** What is on the stage beside the pendulum: told when it is drawn, and when colours change. */
interface StagePart {
    follow?(): void;
    show?(): void;
    destroy?: End;
}

/** A table in the field of the fits, what its columns were taken for, and the fit to it. */
interface Fitting {
    words: string;
    choices: import("./drawers/fits/fit_request.js").Choices;
    fitted: import("./drawers/fits/fit_answer.js").Fitted | null;
}

/** A film that was chosen, where in it, s, and the fit to its marks. */
interface Shot {
    file: File;
    time: number;
    told: string;
    handed: string;
    camera: FitCamera | null;
}

/** Where measured places are: origin + scale e^(i rotation) place, in their own unit. */
interface FitCamera {
    scale: number;
    rotation: number;
    origin: number[];
}

/** What the stage shows, m from where the pivot stands at first. */
interface Seen {
    left: number;
    right: number;
    up: number;
    down: number;
}

interface Point {
    x: number;
    y: number;
}

/** The pivot in pixels, and how many pixels a metre has. */
interface Camera extends Point {
    scale: number;
}

/** How far around the pivot something goes, in metres. */
interface Box {
    side: number;
    up: number;
    down: number;
}

/** Where the joints (from) and the tips of arms are, and the pivot; metres. */
interface Spots {
    x: Float64Array;
    y: Float64Array;
    fromX: Float64Array;
    fromY: Float64Array;
    pivot: Point;
    /** The cart's place on its rail, m. */
    cart: number;
    /** How far beside the middle the pivot is drawn, m. */
    apart: number;
}

/** What depends on the tree only, and where its joints and tips are in this frame. */
interface Shape extends Spots {
    tree: Tree;
    n: number;
    rows: number[];
    reach: number;
    heaviest: number;
    thin: number;
    phi: Float64Array;
    lambda: Float64Array;
    ghostPhi: Float64Array;
    ghost: Spots;
    /** s of the request's own time */
    time: number;
}

interface Colours {
    bins: string[];
    font: string;
    ink: string;
    quiet: string;
    glass: string;
    accent: string;
    paper: string;
    mass: string;
    ghosts: string[];
    trails: string[];
}

/** What is on the stage, for those who ask where. */
interface Look {
    shape: Shape;
    /** Of a second pendulum beside it. */
    second: Shape | null;
    camera: Camera;
    colours: Colours;
    most: number;
    hover: number;
    focused: boolean;
    soon(): void;
    cardHeight(): number;
    cardWidth(): number;
}

interface Bag {
    (end: End): unknown;
    end(): void;
    on(
        target: EventTarget,
        event: string,
        listener: (event: any) => unknown,
        options?: AddEventListenerOptions,
    ): void;
}

/** A function that is called soon, however often it is asked for. */
interface Soon {
    (): void;
    end(): void;
}

interface Drawer {
    show(): unknown;
    hide(): unknown;
    destroy(): unknown;
}

/** What a drawer's file exports by default. */
interface DrawerPart {
    id: string;
    title(text: Text): string;
    mount(element: HTMLElement, app: App): Drawer | Promise<Drawer>;
}

/** One curve of a chart; colour: a property of the page. */
interface Series {
    colour: string;
    dash?: number[] | null;
    width?: number;
    shown?: boolean;
    /** Stands at the curve's right end. */
    name?: string;
}

type ChartData = ArrayLike<number | null>[];

interface Chart {
    set(data: ChartData): void;
    show(i: number, shown: boolean): void;
    range(): void;
    follow(): void;
    point(time: number | null): void;
    destroy(): void;
}

interface ChartOptions {
    series: Series[];
    log?: boolean;
    degrees?: boolean;
    height?: number;
}

interface ChartGroup {
    readonly zoomed: [number, number] | null;
    /** Of the longest name beside a chart. */
    readonly letters: number;
    zoom(from?: number | null, to?: number | null): void;
    magnify(factor: number): void;
    point(time: number | null): void;
    add(host: HTMLElement, options: ChartOptions): Chart;
    remove(chart: Chart): void;
    follow(): void;
    destroy(): void;
}

/** A request of the engine; most: s that it may take by its own estimate. */
interface EngineRequest {
    operation: string;
    argument?: string;
    accept?: string;
    body?: string;
    most?: number;
}

interface Engine {
    readonly ready: boolean;
    begin(): Promise<void>;
    answer(path: string, options: RequestInit, alone: boolean): Promise<Response | null>;
}

interface EngineHead {
    status: number;
    fields: Record<string, string>;
    cost: number;
}

interface Window {
    pendulumd: App;
}
