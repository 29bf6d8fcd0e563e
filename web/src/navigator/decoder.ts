/** The worker's side in the page: surfaces by their address, each fetched once. */
import type { Answered } from "./worker";
import type { Surface } from "./surface";

interface Question {
  resolve(surface: Surface): void;
  reject(error: Error): void;
}

export class Decoder {
  private worker = new Worker("/worker.js", { type: "module" });
  private questions = new Map<number, Question>();
  private surfaces = new Map<string, Promise<Surface>>();
  private next = 1;

  constructor() {
    this.worker.onmessage = (event: MessageEvent<Answered>) => this.take(event.data);
    this.worker.onerror = () => this.fail("The worker that reads surfaces cannot be started in this browser.");
  }

  surface(url: string): Promise<Surface> {
    const known = this.surfaces.get(url);
    if (known) return known;
    const made = new Promise<Surface>((resolve, reject) => {
      const id = this.next++;
      this.questions.set(id, { resolve, reject });
      this.worker.postMessage({ id, url });
    });
    this.surfaces.set(url, made);
    made.catch(() => this.surfaces.delete(url));
    return made;
  }

  /** Forgets all others. */
  keepOnly(urls: string[]): void {
    for (const url of this.surfaces.keys()) if (!urls.includes(url)) this.surfaces.delete(url);
  }

  private take(answer: Answered): void {
    const question = this.questions.get(answer.id);
    this.questions.delete(answer.id);
    if ("error" in answer) question?.reject(new Error(answer.error));
    else question?.resolve(answer.surface);
  }

  private fail(sentence: string): void {
    for (const question of this.questions.values()) question.reject(new Error(sentence));
    this.questions.clear();
  }
}
