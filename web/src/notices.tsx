/** Sentences from the server and from the page, and the state of the connection. */
import { signal, effect } from "@preact/signals";
import { Icon } from "./icons";
import { reconnect } from "./session";
import * as store from "./store";
import { IconButton } from "./ui/controls";

export function Notices() {
  return (
    <div class="notices" role="region" aria-label="Notices">
      {store.notices.value.map((notice) => (
        <div key={notice.key} class={`notice notice-${notice.level}`} role={notice.level === "error" ? "alert" : "status"}>
          <Icon name={notice.level} />
          <span class="notice-text">{notice.text}</span>
          <IconButton icon="close" label="Dismiss this notice" onClick={() => store.dismiss(notice.key)} />
        </div>
      ))}
    </div>
  );
}

export function ConnectionNotice() {
  const { state, why } = store.connection.value;
  if (state === "open" || (state === "connecting" && store.welcome.value)) return null;
  if (state === "connecting") return <div class="curtain"><p class="curtain-words">Connecting</p></div>;
  return (
    <div class={store.welcome.value && state === "lost" ? "banner" : "curtain"} role="alert">
      <Icon name="unplugged" />
      <p class="curtain-words">{why.replace(/\.?$/, ".")}{state === "lost" ? " Trying again." : ""}</p>
      <button type="button" class="button" onClick={reconnect}>Try now</button>
    </div>
  );
}

const ANNOUNCE_MS = 1000;

/** At most one message a second is read out, the newest. */
const spoken = signal("");
let last = 0;
let timer = 0;
effect(() => {
  const text = store.announcement.value;
  clearTimeout(timer);
  timer = window.setTimeout(() => { last = performance.now(); spoken.value = text; }, Math.max(0, ANNOUNCE_MS - (performance.now() - last)));
});

export function LiveRegion() {
  return <div class="hidden" role="status" aria-live="polite">{spoken.value}</div>;
}
