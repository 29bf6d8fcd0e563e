/** Files of this computer: all go to the server, into one folder of their own, then those that can be opened are. */
import { ask } from "./session";
import * as store from "./store";
import { HEADER, SAMPLES, toBeOpened, whyNot } from "./uploads_order";

interface Sent {
  name: string;
  path: string;
}

/** A word that no other page has: files that are sent with it lie in one folder. */
function batchName(): string {
  return [...crypto.getRandomValues(new Uint8Array(16))].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}

async function send(file: File, batch: string): Promise<Sent> {
  const response = await fetch(`/files/${batch}/${encodeURIComponent(file.name)}`, { method: "PUT", body: file, credentials: "same-origin" });
  if (response.status === 413) throw new Error(`${file.name} is larger than the server accepts. Open it by its path on the server.`);
  if (!response.ok) throw new Error(`${file.name} was not accepted: ${(await response.text()).trim() || response.statusText}`);
  const { path } = (await response.json()) as { path: string };
  return { name: file.name, path };
}

/** A header names its samples: where two files of one name are sent together, it reads the first. */
function warnOfNamesTaken(sent: Sent[]): void {
  const renamed = sent.find(({ name, path }) => SAMPLES.test(name) && !path.endsWith(`/${name}`));
  if (renamed && sent.some(({ name }) => HEADER.test(name)))
    store.notify("warning", `Two files are called ${renamed.name}, and headers that name it use the first.`);
}

/** add: beside what is shown. What one of them is refused for does not keep the others. */
export async function upload(list: Iterable<File>, add: boolean): Promise<void> {
  const files = [...list];
  const sentence = whyNot(files);
  if (!files.length) return;
  if (sentence) return store.notify("error", sentence);
  store.notify("info", files.length === 1 ? `${files[0]!.name} is being sent.` : `${files.length} files are being sent.`);
  const sent: Sent[] = [];
  try {
    const batch = batchName();
    for (const file of files) sent.push(await send(file, batch));
  } catch (error) {
    return store.notify("error", (error as Error).message);
  }
  warnOfNamesTaken(sent);
  let beside = add;
  for (const { path } of toBeOpened(sent)) {
    try {
      await ask({ type: "open", path, add: beside });
      beside = true;
    } catch (error) {
      store.notify("error", (error as Error).message);
    }
  }
}
