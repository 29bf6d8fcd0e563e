/** Who is let in, and how to change that. */
import { useState } from "preact/hooks";
import { endSessions } from "../session";
import * as store from "../store";
import { closeDialog, DialogButtons, Modal } from "../ui/dialog";

export function SessionsDialog() {
  const [error, setError] = useState("");
  const [busy, setBusy] = useState(false);
  const others = store.people.value - 1;
  const end = () => {
    setBusy(true);
    endSessions().then(() => {
      store.notify("info", "All other sessions are ended. The program has printed another link.");
      closeDialog();
    }, (e: Error) => {
      setError(e.message);
      setBusy(false);
    });
  };
  return (
    <Modal title="Who is let in">
      <p>{others > 0 ? `${others} other ${others === 1 ? "page shows" : "pages show"} this scene.` : "No other page shows this scene."}</p>
      <p class="doc">
        Whoever has the link of this session can do all that you can. If all sessions are ended, other pages are sent away, and
        neither the link nor what it left in their browsers lets in any more. The program prints another link in its terminal;
        this page and the scene stay.
      </p>
      {error ? <p class="row-error" role="alert">{error}</p> : null}
      <DialogButtons>
        <span class="grow" />
        <button type="button" class="button" onClick={closeDialog}>Cancel</button>
        <button type="button" class="button button-main" disabled={busy} onClick={end}>End all sessions</button>
      </DialogButtons>
    </Modal>
  );
}
