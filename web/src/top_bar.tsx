/** The line at the top: files, undo, search, theme, help, and the panels. */
import { allActions, runAction } from "./actions";
import { Icon, type IconName } from "./icons";
import { keycaps } from "./keys";
import { isOpen as measuring } from "./measure/room";
import * as store from "./store";
import { theme } from "./theme";
import { IconButton } from "./ui/controls";

function ActionButton({ name, icon, pressed }: { name: string; icon?: IconName; pressed?: boolean }) {
  const action = allActions().find((row) => row.name === name);
  if (!action) return null;
  return (
    <IconButton
      icon={icon ?? action.icon!} label={action.title} keys={action.keys?.[0] ? keycaps(action.keys[0]).join("+") : undefined} pressed={pressed}
      disabled={action.enabled?.() === false} onClick={() => runAction(name)}
    />
  );
}

export function TopBar() {
  return (
    <header class="top">
      <ActionButton name="left-panel" pressed={store.leftOpen.value} />
      <span class="brand"><img src="/icon.svg" alt="" width="20" height="20" /><span>VolVis</span></span>
      <div class="tool-group" role="toolbar" aria-label="Scene">
        <ActionButton name="new" />
        <ActionButton name="open" />
        <ActionButton name="save" />
        <span class="divider" />
        <ActionButton name="undo" />
        <ActionButton name="redo" />
        <span class="divider" />
        <ActionButton name="fit" />
        <ActionButton name="split" pressed={store.split.value} />
        <ActionButton name="slices" pressed={store.layout.value === "slices"} />
        <ActionButton name="measure" pressed={measuring.value} />
        <ActionButton name="picture" />
        <ActionButton name="command" />
      </div>
      <h1 class="scene-title">{store.shownTitle.value || "Nothing is open"}{store.readOnly.value ? <span class="badge">read-only</span> : null}</h1>
      <button type="button" class="search-button" onClick={() => runAction("search")}>
        <Icon name="search" />
        <span class="search-words">Search commands</span>
        <span class="keys" aria-hidden="true"><kbd>Ctrl</kbd><kbd>K</kbd></span>
      </button>
      <div class="tool-group" role="toolbar" aria-label="Page">
        <IconButton icon="theme" label={theme.value === "dark" ? "Light theme" : "Dark theme"} onClick={() => runAction("theme")} />
        <ActionButton name="help" />
        <ActionButton name="right-panel" pressed={store.rightOpen.value} />
      </div>
    </header>
  );
}
