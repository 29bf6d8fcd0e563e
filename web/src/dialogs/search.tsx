/** Command search: everything that can be done or set, by name. */
import { useMemo, useRef, useState } from "preact/hooks";
import { allActions } from "../actions";
import { Icon } from "../icons";
import { keycaps } from "../keys";
import { findBest } from "../search";
import { closeDialog, Modal } from "../ui/dialog";

const MOST = 60;

export function SearchDialog() {
  const [query, setQuery] = useState("");
  const [current, setCurrent] = useState(0);
  const list = useRef<HTMLUListElement>(null);
  const actions = useMemo(() => allActions().filter((action) => action.name !== "search"), []);
  const found = findBest(query, actions, (action) => [action.title, `${action.group} ${action.doc ?? ""}`], MOST);
  const at = Math.min(current, found.length - 1);

  const run = (index: number) => {
    const action = found[index];
    if (!action || action.enabled?.() === false) return;
    closeDialog();
    setTimeout(action.run); // when the focus is back where it was
  };
  const show = (index: number) => {
    setCurrent(index);
    list.current?.children[index]?.scrollIntoView({ block: "nearest" });
  };
  const onKeyDown = (event: KeyboardEvent) => {
    const by = { ArrowDown: 1, ArrowUp: -1, PageDown: 8, PageUp: -8 }[event.key];
    if (by) show(Math.max(0, Math.min(found.length - 1, at + by)));
    else if (event.key === "Enter") run(at);
    else return;
    event.preventDefault();
  };

  return (
    <Modal title="Search commands" bare>
      <div class="search-box">
        <Icon name="search" />
        <input
          type="text" role="combobox" aria-label="Command, operation, property, preset or method" aria-expanded="true" aria-controls="search-list"
          aria-activedescendant={found.length ? `search-${at}` : undefined} autocomplete="off" spellcheck={false} autofocus
          placeholder="Command, operation, property, preset, method" value={query}
          onInput={(e) => { setQuery(e.currentTarget.value); setCurrent(0); }} onKeyDown={onKeyDown}
        />
      </div>
      {found.length ? null : <p class="empty-words">No matches. Fewer letters find more.</p>}
      <ul id="search-list" ref={list} class="search-list" role="listbox" aria-label="Search results">
        {found.map((action, i) => (
          <li
            key={action.name} id={`search-${i}`} role="option" aria-selected={i === at} aria-disabled={action.enabled?.() === false || undefined}
            class="search-row" onClick={() => run(i)} onPointerMove={() => setCurrent(i)}
          >
            {action.icon ? <Icon name={action.icon} /> : <span class="icon" />}
            <span class="search-title">{action.title}{action.doc ? <span class="search-doc">{action.doc}</span> : null}</span>
            <span class="search-group">{action.group}</span>
            {action.keys?.[0] ? <Keys chord={action.keys[0]} /> : null}
          </li>
        ))}
      </ul>
    </Modal>
  );
}

export function Keys({ chord }: { chord: string }) {
  return <span class="keys">{keycaps(chord).map((key, i) => <kbd key={i}>{key}</kbd>)}</span>;
}
