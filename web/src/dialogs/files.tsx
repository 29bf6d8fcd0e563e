/** Open, save, save a picture, show the command line. */
import { useEffect, useRef, useState } from "preact/hooks";
import { Refusal } from "../connection";
import { ask } from "../session";
import * as store from "../store";
import { NumberField } from "../ui/controls";
import { closeDialog, DialogButtons, Modal } from "../ui/dialog";
import { upload } from "../uploads";
import { FolderBrowser, joinPath, startFolder } from "./browser";

/** A request whose refusal is shown in the dialog, which stays. */
function useRequest(): [string, (message: { type: string; [name: string]: unknown }, then: (value: never) => void, refused?: (error: Error) => void) => void] {
  const [error, setError] = useState("");
  const run = (message: { type: string; [name: string]: unknown }, then: (value: never) => void, refused?: (error: Error) => void) => {
    setError("");
    ask(message).then(then as (value: unknown) => void, (e: Error) => {
      setError(e.message);
      refused?.(e);
    });
  };
  return [error, run];
}

function ErrorLine({ text }: { text: string }) {
  return text ? <p class="row-error" role="alert">{text}</p> : null;
}

export function OpenDialog({ add }: { add: boolean }) {
  const [folder, setFolder] = useState(startFolder); // Enter may come before the list does
  const [name, setName] = useState("");
  const file = useRef<HTMLInputElement>(null);
  const [error, request] = useRequest();
  const path = name && joinPath(folder, name);
  // The answer comes when the file is open, which may take long: what is refused at once keeps the dialog.
  const open = (what: string) => {
    if (!what) return;
    const going = window.setTimeout(closeDialog, 600);
    request({ type: "open", path: what, add }, closeDialog, () => clearTimeout(going));
  };
  return (
    <Modal title={add ? "Add a file to the scene" : "Open a file"} wide>
      <FolderBrowser picked={path} onFolder={setFolder} onPick={(full) => setName(full.split("/").pop()!)} onRun={open} />
      <label class="dialog-row">
        <span>Path</span>
        <input type="text" class="plain-field" spellcheck={false} autocomplete="off" value={name} placeholder="a file, scene or picture in this folder, or from / on"
          onInput={(e) => setName(e.currentTarget.value)} onKeyDown={(e) => e.key === "Enter" && open(path)} />
      </label>
      <ErrorLine text={error} />
      <DialogButtons>
        <input ref={file} type="file" multiple class="hidden" tabIndex={-1} aria-label="Files on this computer" onChange={(e) => {
          const chosen = [...(e.currentTarget.files ?? [])];
          closeDialog();
          void upload(chosen, add);
        }} />
        <button type="button" class="button" onClick={() => file.current?.click()}>From this computer</button>
        <span class="grow" />
        <button type="button" class="button" onClick={closeDialog}>Cancel</button>
        <button type="button" class="button button-main" disabled={!path} onClick={() => open(path)}>Open</button>
      </DialogButtons>
    </Modal>
  );
}

export function SaveDialog() {
  return <SaveAs title="Save the scene" first="scene.vv.json" message={{ type: "save" }} />;
}

/** Samples or triangles; the suffix says in which format. */
export function WriteDialog({ dataset }: { dataset: string }) {
  return <SaveAs title={`Save ${dataset} as a file`} first={`${dataset}${store.isMeshData(dataset) ? ".ply" : ".nrrd"}`} message={{ type: "write", dataset }} />;
}

function SaveAs({ title, first, message }: { title: string; first: string; message: { type: string; [name: string]: unknown } }) {
  const [folder, setFolder] = useState(startFolder); // Enter may come before the list does
  const [name, setName] = useState(first);
  const [error, request] = useRequest();
  const [there, setThere] = useState(""); // the path of a file that would be replaced
  const path = joinPath(folder, name);
  const save = (replace = false) => request({ ...message, path, replace }, ((value: { path: string; note?: string }) => {
    store.notify("info", `Saved as ${value.path}.${value.note ? ` ${value.note}` : ""}`);
    closeDialog();
  }) as (value: never) => void, (refused) => setThere(refused instanceof Refusal && refused.reason === "exists" ? path : ""));
  const isThere = there !== "" && there === path;
  return (
    <Modal title={title} wide>
      <FolderBrowser picked={path} onFolder={setFolder} onPick={(full) => setName(full.split("/").pop()!)} onRun={() => {}} />
      <label class="dialog-row">
        <span>Name</span>
        <input type="text" class="plain-field" spellcheck={false} autocomplete="off" value={name} onInput={(e) => setName(e.currentTarget.value)} onKeyDown={(e) => e.key === "Enter" && save()} />
      </label>
      <ErrorLine text={error && (isThere || !there) ? error : ""} />
      <DialogButtons>
        <span class="grow" />
        <button type="button" class="button" onClick={closeDialog}>Cancel</button>
        {isThere
          ? <button type="button" class="button button-main" onClick={() => save(true)}>Replace</button>
          : <button type="button" class="button button-main" disabled={!name} onClick={() => save()}>Save</button>}
      </DialogButtons>
    </Modal>
  );
}

const SIZES: [string, number, number][] = [["1280 × 720", 1280, 720], ["1920 × 1080", 1920, 1080], ["3840 × 2160", 3840, 2160], ["4096 × 4096", 4096, 4096]];
const SIDE_MOST = 32768;

export function PictureDialog({ plain: first }: { plain: boolean }) {
  const [plain, setPlain] = useState(first);
  const full = store.frame.value;
  const [width, setWidth] = useState(full?.fullWidth || 1920);
  const [height, setHeight] = useState(full?.fullHeight || 1080);
  const [name, setName] = useState("picture.png");
  const [error, request] = useRequest();
  const [busy, setBusy] = useState(false);
  const side = (text: string, set: (n: number) => void) => { const n = Math.round(Number(text)); if (n >= 1 && n <= SIDE_MOST) set(n); };
  const save = () => {
    setBusy(true);
    request({ type: "picture", width, height, name, plain }, ((value: { url: string }) => {
      download(value.url, name);
      closeDialog();
    }) as (value: never) => void);
  };
  useEffect(() => { if (error) setBusy(false); }, [error]);
  return (
    <Modal title="Save a picture">
      <p class="doc">The picture is rendered again at this size and holds its scene: VolVis can open it as a scene.</p>
      <div class="dialog-row"><span>Size</span>
        <NumberField label="Width" value={width} unit="px" onCommit={(t) => side(t, setWidth)} />
        <span aria-hidden="true">×</span>
        <NumberField label="Height" value={height} unit="px" onCommit={(t) => side(t, setHeight)} />
      </div>
      <div class="chips">
        {full?.fullWidth ? <button type="button" class="chip" onClick={() => { setWidth(full.fullWidth); setHeight(full.fullHeight); }}>As shown</button> : null}
        {SIZES.map(([text, w, h]) => <button key={text} type="button" class="chip" aria-pressed={w === width && h === height} onClick={() => { setWidth(w); setHeight(h); }}>{text}</button>)}
      </div>
      <label class="dialog-row"><span>Name</span>
        <input type="text" class="plain-field" spellcheck={false} value={name} onInput={(e) => setName(e.currentTarget.value)} />
      </label>
      <label class="dialog-row"><span>Without overlays</span>
        <input type="checkbox" checked={plain} onChange={(e) => setPlain(e.currentTarget.checked)} />
      </label>
      <ErrorLine text={error} />
      <DialogButtons>
        <span class="grow" />
        <button type="button" class="button" onClick={closeDialog}>Cancel</button>
        <button type="button" class="button button-main" disabled={busy || !name} onClick={save}>{busy ? "Rendering" : "Save"}</button>
      </DialogButtons>
    </Modal>
  );
}

function download(url: string, name: string): void {
  const link = document.createElement("a");
  link.href = url;
  link.download = name;
  document.body.append(link);
  link.click();
  link.remove();
}

/** Where the clipboard is forbidden, the line is shown to be copied by hand. */
export function CommandDialog({ text }: { text: string }) {
  return (
    <Modal title="The same as a command line" wide>
      <textarea class="numbers command-text" rows={6} readOnly aria-label="Command line" value={text} onFocus={(e) => e.currentTarget.select()} />
      <DialogButtons>
        <span class="grow" />
        <button type="button" class="button button-main" onClick={closeDialog}>Done</button>
      </DialogButtons>
    </Modal>
  );
}
