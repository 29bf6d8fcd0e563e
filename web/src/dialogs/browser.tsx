/** The server's folders: where one is, what is there, and a line to type a path in. */
import type { TargetedKeyboardEvent } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { Icon, type IconName } from "../icons";
import type { FolderEntry } from "../protocol";
import { ask } from "../session";
import { keep, kept } from "../storage";
import * as store from "../store";
import { formatBytes } from "../values";

const ICONS: { [kind: string]: IconName } = { volume: "volume", mesh: "mesh", scene: "scene", picture: "picture" };

function parentOf(path: string): string {
  return path.replace(/\/+$/, "").replace(/[^/]*$/, "").replace(/\/+$/, "");
}

export function joinPath(folder: string, name: string): string {
  return folder === "" || name.startsWith("/") ? name : `${folder.replace(/\/+$/, "")}/${name}`;
}

let lastFolder = kept("folder");

function keepFolder(path: string): void {
  lastFolder = path;
  keep("folder", path);
}

function Crumbs({ path, go }: { path: string; go: (path: string) => void }) {
  const parts = path.split("/").filter(Boolean);
  const start = path.startsWith("/") ? "/" : "";
  return (
    <nav class="crumbs" aria-label="Folder">
      <button type="button" class="crumb" onClick={() => go("")}>Root</button>
      {parts.map((part, i) => (
        <>
          <span aria-hidden="true">/</span>
          <button key={i} type="button" class="crumb" aria-current={i === parts.length - 1 ? "location" : undefined} onClick={() => go(start + parts.slice(0, i + 1).join("/"))}>{part}</button>
        </>
      ))}
    </nav>
  );
}

/** Where one was last, or where the program was started. */
export function startFolder(): string {
  return lastFolder ?? store.welcome.value?.folder ?? "";
}

export function FolderBrowser({ onFolder, onPick, onRun, picked }: {
  onFolder: (path: string) => void; onPick: (path: string) => void; onRun: (path: string) => void; picked: string;
}) {
  const [path, setPath] = useState("");
  const [entries, setEntries] = useState<FolderEntry[] | null>(null);
  const [error, setError] = useState("");
  const list = useRef<HTMLUListElement>(null);

  const go = (to: string) => {
    setError("");
    ask<{ path: string; entries: FolderEntry[] }>({ type: "browse", path: to }).then(
      (value) => { setPath(value.path); setEntries(value.entries); onFolder(value.path); keepFolder(value.path); },
      (e: Error) => { setError(e.message); setEntries((now) => now ?? []); },
    );
  };
  // The root where that is not there any more.
  useEffect(() => {
    const start = startFolder();
    ask({ type: "browse", path: start }).then(() => go(start), () => go(""));
  }, []);

  // A folder that is a volume is opened like a file.
  const leadsOn = (entry: FolderEntry) => entry.folder && !entry.kind;
  const choose = (entry: FolderEntry) => (leadsOn(entry) ? go(joinPath(path, entry.name)) : onPick(joinPath(path, entry.name)));
  const onKeyDown = (event: TargetedKeyboardEvent<HTMLUListElement>) => {
    const buttons = [...list.current!.querySelectorAll<HTMLElement>("button")];
    const at = buttons.indexOf(document.activeElement as HTMLElement);
    const by = { ArrowDown: 1, ArrowUp: -1, Home: -at, End: buttons.length - 1 - at }[event.key];
    if (by === undefined) return;
    buttons[Math.max(0, Math.min(buttons.length - 1, at + by))]?.focus();
    event.preventDefault();
  };

  return (
    <div class="browser">
      <Crumbs path={path} go={go} />
      {error ? <p class="row-error" role="alert">{error}</p> : null}
      <ul ref={list} class="entries" aria-label="Files" onKeyDown={onKeyDown}>
        {path.replace(/\/+$/, "") !== "" ? <li><button type="button" class="entry" onClick={() => go(parentOf(path))}><Icon name="up" /><span class="entry-name">One folder up</span></button></li> : null}
        {(entries ?? []).map((entry) => {
          const full = joinPath(path, entry.name);
          return (
            <li key={entry.name}>
              <button
                type="button" class={`entry ${full === picked ? "entry-picked" : ""} ${!entry.folder && !entry.kind ? "entry-other" : ""}`}
                aria-pressed={leadsOn(entry) ? undefined : full === picked} onClick={() => choose(entry)} onDblClick={() => { if (!leadsOn(entry)) onRun(full); }}
              >
                <Icon name={leadsOn(entry) ? "folder" : (ICONS[entry.kind ?? ""] ?? "file")} />
                <span class="entry-name">{entry.name}</span>
                <span class="entry-kind">{leadsOn(entry) ? "folder" : (entry.kind ?? "")}</span>
                <span class="entry-bytes">{entry.folder ? "" : formatBytes(entry.bytes)}</span>
              </button>
            </li>
          );
        })}
        {entries && !entries.length && !error ? <li class="empty-words">This folder is empty.</li> : null}
      </ul>
    </div>
  );
}
