// The shapes that the modules of a class hand each other; what stands in a room has the shapes of
// api/call/openapi.yaml (ClassStage and the others).
// Leaves to others: what is done with them. Nothing here is part of a bundle.
// Invariant: what comes from the server has been checked by it; texts are shown as texts.

interface ClassScene {
    request: any;
    view?: Record<string, any>;
}

/** What the whole class is shown. */
interface ClassStage {
    scene?: ClassScene;
    frozen?: boolean;
    open?: boolean;
    address_share?: number;
    text?: string;
    question?: string;
    worksheet?: string;
    release?: { number: number; spread?: number };
    /** The last step of the worksheet that may be opened. */
    pace?: number;
    follow?: { drawer?: string; time?: number; playing?: boolean };
}

/** What a pupil has on the stage. */
interface OwnStage {
    scene?: ClassScene;
    state?: string;
    release?: number;
    step?: string;
    /** s without a change; a page that is awake writes it again and again */
    idle?: number;
}

/** A question of its own, or of a step of a worksheet, which has the right answer with it. */
interface Question {
    text?: string;
    kind: string;
    unit?: string;
    choices?: string[];
    scene?: ClassScene;
    closed?: boolean;
    value?: number | string;
    tolerance?: number;
}

interface Solution {
    value?: number | string;
    tolerance?: number;
    text?: string;
    shown?: boolean;
}

interface Step {
    id: string;
    title?: string;
    text?: string;
    scene?: ClassScene;
    question?: Question;
    hint?: string;
    needs?: string;
    hidden_until?: string;
}

interface Sheet {
    title: string;
    language?: string;
    closed?: boolean;
    /** When it is told what is right: "at_once" (left out), "at_end", "never". */
    feedback?: string;
    steps: Step[];
}

interface StepAnswer {
    step: string;
    value: number | string;
    scene?: ClassScene;
    /** Earlier answers, the first one first. */
    tries?: (number | string)[];
}

interface Handin {
    done?: boolean;
    answers: StepAnswer[];
}

/** An item of a room: what it is named by, and when it was written. */
interface ClassItem {
    name: string;
    version: number;
    changed: string;
    value: any;
}

/** A room that this browser is or was in, as the browser keeps it. */
interface RoomEntry {
    code: string;
    role: string;
    token: string;
    ends: string;
    /** Of a teacher: kept beyond this tab. */
    remembered?: boolean;
    nickname?: string;
    pupil?: number;
    /** Of a pupil: the scene that was left for the class's, and which of those has been seen. */
    mine?: ClassScene;
    seen?: string;
    released?: number;
    /** Of a teacher: the class follows this device. */
    presents?: boolean;
}

/** A room as this browser is in it. */
interface Session {
    readonly entry: RoomEntry | null;
    /** "none", "coming", "live", "away" or "gone". */
    readonly state: string;
    readonly items: Map<string, ClassItem>;
    /** How many pupils there were when this browser came. */
    readonly pupils: number;
    make(hours: number, remembered?: boolean): Promise<void>;
    join(code: string, nickname: string): Promise<void>;
    resume(code: string | null): Promise<boolean>;
    lead(code: string, token: string): Promise<boolean>;
    /** The server's clock, ms. */
    now(): number;
    /** Writes what the browser keeps of the room. */
    note(patch: Partial<RoomEntry>): void;
    leave(): void;
    value(name: string): any;
    put(
        path: string,
        value: object,
        options?: { signal?: AbortSignal; keepalive?: boolean },
    ): Answer;
    drop(path: string): Promise<unknown>;
    erase(): Promise<void>;
    /** fn(names) after items have come, fn(null) when the room itself is another. */
    subscribe(fn: (names: Set<string> | null) => unknown): End;
}

/** Where one works on a worksheet or a question: in a room, or alone. */
interface Bench {
    app: App;
    say: Text;
    session?: Session;
}

/** What the modules of a class know. */
interface Room extends Bench {
    session: Session;
    /** Says it to those who listen. */
    tell(words: string): void;
    /** Nobody's name is shown: the screen is what the class sees. */
    anonymous?: boolean;
}
