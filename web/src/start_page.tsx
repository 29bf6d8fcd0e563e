/** What is seen before anything is open: how to begin. */
import { Icon } from "./icons";
import { tryAsk } from "./session";
import * as store from "./store";
import { upload } from "./uploads";
import { useRef } from "preact/hooks";
import { label } from "./values";

export function StartPage() {
  const file = useRef<HTMLInputElement>(null);
  const samples = store.welcome.value?.samples ?? [];
  const busy = store.jobs.value.length > 0;
  return (
    <div class="start">
      <div class="start-inside">
        <img class="start-mark" src="/icon.svg" alt="" width="56" height="56" />
        <h1>See inside your data</h1>
        <p class="start-words">Open a volume or a mesh: NIfTI, DICOM, NRRD, TIFF, HDF5, Zarr, VTK, STL and many more. The first picture needs no settings.</p>
        <div class="start-buttons">
          <button type="button" class="button button-main button-large" disabled={store.readOnly.value} onClick={() => { store.dialog.value = { name: "open", add: false }; }}>
            <Icon name="open" /> Open a file
          </button>
          <button type="button" class="button button-large" disabled={store.readOnly.value} onClick={() => file.current?.click()}>
            <Icon name="file" /> From this computer
          </button>
          <input ref={file} type="file" multiple class="hidden" tabIndex={-1} aria-label="Files on this computer" onChange={(e) => {
            void upload(e.currentTarget.files ?? [], false);
          }} />
        </div>
        <p class="hint">or drop files on this page, a header together with its samples</p>
        {samples.length ? (
          <section class="samples" aria-labelledby="samples-title">
            <h2 id="samples-title">Try a sample</h2>
            <ul>
              {samples.map((sample) => (
                <li key={sample.name}>
                  <button type="button" class="sample" disabled={busy || store.readOnly.value} onClick={() => void tryAsk({ type: "sample", name: sample.name })}>
                    <span class="sample-name">{label(sample.name)}</span>
                    <span class="sample-doc">{sample.doc}</span>
                  </button>
                </li>
              ))}
            </ul>
          </section>
        ) : null}
      </div>
    </div>
  );
}
