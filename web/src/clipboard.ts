/** The clipboard. */
import * as store from "./store";

/** done: what is said then; by itself that of a command line. */
export async function copyText(text: string, done = "The command line is copied."): Promise<void> {
  try {
    await navigator.clipboard.writeText(text);
    store.notify("info", done);
  } catch {
    store.dialog.value = { name: "command", text }; // shown, to be copied by hand
  }
}
