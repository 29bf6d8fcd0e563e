/** Sentences of operations as the panel says them: what command lines have in them is named as the fields are. */
import type { Operation, Property } from "../protocol";
import * as store from "../store";
import { label, sentence } from "../values";

/** "threshold: range is needed; or --method otsu" is "Range is needed; or Method otsu."; "`volvis distance --side inside`"
    is an entry of the menu, Distance (Side inside). */
export function inPanel(text: string, operation: Operation, rows: Property[], all: Operation[] = store.welcome.value?.operations ?? []): string {
  const known = (name: string) => rows.some((row) => row.name === name);
  const plain = text
    .replace(/^parameters\.(\w+)/, (_, name: string) => label(name))
    .replace(new RegExp(`(^|: )${operation.name}: `), "$1")
    .replace(/ \(\w+=FILE\)/g, "")
    .replace(/([`'])(?:volvis )?([a-z][a-z-]*)(?: --([a-z-]+)( [^`']*)?)?\1/g, (whole, _, name: string, option?: string, value = "") =>
      (all.some((row) => row.name === name) ? label(name) + (option ? ` (${label(option)}${value})` : "") : whole))
    .replace(/--(no-)?([a-z][a-z-]*)/g, (all, _, name: string) => (known(name.replace(/-/g, "_")) ? label(name) : all));
  return sentence(plain);
}
