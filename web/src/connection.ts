/** The one connection to the server: who is let in, questions and answers, and coming back after it was lost. */
import type { Json, ServerMessage } from "./protocol";

export type ConnectionState = "connecting" | "open" | "lost" | "refused";

export interface ConnectionEvents {
  state(state: ConnectionState, why: string): void;
  message(message: ServerMessage): void;
  binary(buffer: ArrayBuffer): void;
}

/** Milliseconds until try number n, from 0: doubling from a quarter of a second to eight seconds. */
export function backOff(n: number): number {
  return Math.min(8000, 250 * 2 ** Math.min(n, 10));
}

/** Takes the token out of the address, so that neither history nor screenshots keep it. */
export function takeToken(): string | null {
  const token = location.hash.slice(1);
  if (token) history.replaceState(null, "", location.pathname + location.search);
  return token || null;
}

/** What the server refused; `reason`: a word by which the page knows what to offer. */
export class Refusal extends Error {
  constructor(sentence: string, readonly reason: string | undefined) {
    super(sentence);
  }
}

interface Question {
  resolve(value: Json): void;
  reject(error: Error): void;
}

export class Connection {
  private socket: WebSocket | null = null;
  private questions = new Map<number, Question>();
  private next = 1;
  private tries = 0;
  private timer = 0;
  private closed = false;
  private entered = false; // the link was taken: it may work once, and the cookie lets in from now on

  constructor(private events: ConnectionEvents, private token: string | null) {}

  async start(): Promise<void> {
    this.events.state("connecting", "");
    const entered = await this.enter();
    if (this.closed) return;
    if (entered === "refused") {
      this.events.state("refused", "This link is no longer valid. Open the link that VolVis printed last.");
    } else if (entered === "unreachable") {
      this.retry("The server does not answer.");
    } else {
      this.open();
    }
  }

  /** At once, instead of when the next try is due. */
  retryNow(): void {
    clearTimeout(this.timer);
    this.tries = 0;
    void this.start();
  }

  /** Leaves, and comes again. */
  restart(): void {
    const socket = this.socket;
    this.socket = null;
    this.rejectAll();
    socket?.close();
    this.retryNow();
  }

  /** Everybody is sent away, and the old link lets in no more. Who asks has another cookie, and comes again. */
  async endAll(): Promise<void> {
    const response = await fetch("/session", { method: "DELETE", credentials: "same-origin" });
    if (!response.ok) throw new Error((await response.text()).trim() || "The server did not end the sessions.");
    this.token = null; // of the old link
    this.restart();
  }

  /** For good. */
  close(): void {
    clearTimeout(this.timer);
    const socket = this.socket;
    this.socket = null; // what it says when it closes is not heard
    this.closed = true;
    socket?.close();
  }

  send(message: { type: string; [name: string]: unknown }): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  /** Rejects with the server's sentence, or when the connection is lost. */
  ask<T = Json>(message: { type: string; [name: string]: unknown }): Promise<T> {
    const id = this.next++;
    return new Promise<T>((resolve, reject) => {
      if (!this.send({ ...message, id })) {
        reject(new Error("There is no connection to the server."));
        return;
      }
      this.questions.set(id, { resolve: resolve as (value: Json) => void, reject });
    });
  }

  /** The cookie of an earlier visit lets in without a token: the WebSocket will tell. */
  private async enter(): Promise<"ok" | "refused" | "unreachable"> {
    if (!this.token || this.entered) return "ok";
    try {
      const response = await fetch("/session", {
        method: "POST",
        headers: { "Content-Type": "application/json" },
        body: JSON.stringify({ token: this.token }),
        credentials: "same-origin",
      });
      this.entered = response.ok;
      return response.ok ? "ok" : response.status === 403 ? "refused" : "unreachable";
    } catch {
      return "unreachable";
    }
  }

  private open(): void {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}/ws`, "volvis");
    let opened = false;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      opened = true;
      this.tries = 0;
      this.events.state("open", "");
    };
    socket.onmessage = (event) => {
      if (typeof event.data === "string") this.take(JSON.parse(event.data) as ServerMessage);
      else this.events.binary(event.data as ArrayBuffer);
    };
    socket.onclose = (event) => {
      if (this.socket !== socket) return;
      this.socket = null;
      this.rejectAll();
      if (opened) this.retry(event.reason || "The connection to the server was lost.");
      else void this.refusedOrGone();
    };
    this.socket = socket;
  }

  /** A WebSocket does not say why it was not let in; whether the page itself can be had does. */
  private async refusedOrGone(): Promise<void> {
    const there = await fetch("/icon.svg", { cache: "no-store" }).then((r) => r.ok, () => false);
    if (this.closed) return;
    if (there && !this.token) {
      this.events.state("refused", "The server can be opened only with its link. Open the link that VolVis printed.");
    } else {
      if (there) this.entered = false; // another server, perhaps, which the link is for as well
      this.retry("The server does not answer.");
    }
  }

  private take(message: ServerMessage): void {
    if (message.type !== "answer") {
      this.events.message(message);
      return;
    }
    const question = this.questions.get(message.id);
    this.questions.delete(message.id);
    if (message.ok) question?.resolve(message.value ?? null);
    else question?.reject(new Refusal(message.error ?? "The server gave no reason.", message.reason));
  }

  private rejectAll(): void {
    const lost = [...this.questions.values()];
    this.questions.clear();
    for (const question of lost) question.reject(new Error("The connection was lost before the answer came."));
  }

  private retry(why: string): void {
    this.events.state("lost", why);
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => void this.start(), backOff(this.tries++));
  }
}
