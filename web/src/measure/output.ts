/** What leaves the room: the clipboard, and files of this computer. */
import * as store from "../store";

export async function copy(text: string, done: string): Promise<void> {
  try {
    await navigator.clipboard.writeText(text);
    store.notify("info", done);
  } catch {
    store.dialog.value = { name: "command", text }; // shown, to be copied by hand
  }
}

export function saveText(text: string, name: string, type: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: `${type};charset=utf-8` }));
  link.download = name;
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
