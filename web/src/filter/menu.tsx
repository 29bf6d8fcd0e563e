/** The Filter menu: all operations by groups, found by their words; what does not fit the data says why. */
import { useRef, useState } from "preact/hooks";
import { Icon } from "../icons";
import type { Operation } from "../protocol";
import { findBest } from "../search";
import * as store from "../store";
import { closeDialog, Modal } from "../ui/dialog";
import { label, sentence, titleOf, valueAt } from "../values";
import { begin, hindrance } from "./state";
import { inPanel } from "./words";

const ALL = 1000;

/** Up to the first stop: the rest is in the panel. */
function shortDoc({ doc, ...operation }: Operation): string {
  return inPanel(doc.split(/[;:]/)[0]!.trim(), { doc, ...operation }, []);
}

function Entry({ operation, after }: { operation: Operation; after?: string }) {
  const why = hindrance(operation, after);
  const choose = () => {
    if (why) return;
    closeDialog();
    setTimeout(() => begin(operation.name, after)); // when the focus is back where it was
  };
  return (
    <li>
      <button type="button" class="filter-entry" aria-disabled={why !== "" || undefined} onClick={choose}>
        <span class="filter-name">{label(operation.name)}</span>
        <span class="filter-doc">{why ? sentence(why) : shortDoc(operation)}</span>
      </button>
    </li>
  );
}

export function FilterMenu({ after }: { after?: string }) {
  const [query, setQuery] = useState("");
  const body = useRef<HTMLDivElement>(null);
  const operations = store.welcome.value?.operations ?? [];
  const found = query ? findBest(query, operations, (row) => [label(row.name), `${row.name} ${row.group} ${row.doc}`], ALL) : operations;
  const groups = [...new Set((query ? found : operations).map((row) => row.group))];
  const shown = store.currentVolume.value ? store.datasetOf(store.currentVolume.value) : null;
  const entries = () => [...(body.current?.querySelectorAll<HTMLElement>(".filter-entry") ?? [])];
  const onKeyDown = (event: KeyboardEvent) => {
    const by = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    const all = entries();
    if (by) {
      const at = all.indexOf(document.activeElement as HTMLElement) + by;
      if (at >= 0) all[Math.min(at, all.length - 1)]?.focus();
      else document.querySelector<HTMLElement>(".filter-menu input")?.focus();
    } else if (event.key === "Enter" && document.activeElement instanceof HTMLInputElement) all.find((entry) => !entry.hasAttribute("aria-disabled"))?.click();
    else return;
    event.preventDefault();
  };
  return (
    <Modal title={after ? "Insert a step" : "Filter"} wide bare>
      <div class="filter-menu" onKeyDown={onKeyDown}>
        <div class="search-box">
          <Icon name="search" />
          <input type="text" aria-label="Find an operation" autocomplete="off" spellcheck={false} placeholder={after ? `Insert a step after ${after}` : "Find an operation"} value={query} onInput={(e) => setQuery(e.currentTarget.value)} />
          {shown ? <span class="filter-of">on <strong>{titleOf(valueAt(store.world.value, `datasets.${after ?? shown}`), after ?? shown)}</strong></span> : null}
        </div>
        <div class="filter-groups" ref={body}>
          {groups.map((group) => (
            <section key={group} class="filter-group" aria-label={label(group)}>
              <h3>{label(group)}</h3>
              <ul>{found.filter((row) => row.group === group).map((row) => <Entry key={row.name} operation={row} after={after} />)}</ul>
            </section>
          ))}
          {found.length ? null : <p class="empty-words">No matches. Fewer letters find more.</p>}
        </div>
      </div>
    </Modal>
  );
}
