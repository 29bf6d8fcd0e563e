/** A modal dialog: the browser's own element keeps the focus inside and gives it back. */
import type { ComponentChildren } from "preact";
import { useLayoutEffect, useRef } from "preact/hooks";
import { dialog } from "../store";
import { IconButton } from "./controls";

export function closeDialog(): void {
  dialog.value = null;
}

/** The browser would take the first button, which closes. */
function focusFirstField(modal: HTMLElement): void {
  const field = modal.querySelector<HTMLElement>("input:not([type=file]), select, textarea");
  field?.focus();
  if (field instanceof HTMLInputElement && field.type === "text") field.select();
}

export function Modal({ title, wide, bare, children }: { title: string; wide?: boolean; bare?: boolean; children: ComponentChildren }) {
  const element = useRef<HTMLDialogElement>(null);
  useLayoutEffect(() => { // before any further key: what had the focus is where it goes back to
    const modal = element.current!;
    const before = document.activeElement as HTMLElement | null;
    modal.showModal();
    focusFirstField(modal);
    return () => {
      modal.close();
      before?.focus?.();
    };
  }, []);
  return (
    <dialog
      ref={element} class={`modal ${wide ? "modal-wide" : ""} ${bare ? "modal-bare" : ""}`} aria-label={title}
      onClose={() => { if (element.current?.isConnected) closeDialog(); }} // the browser may close it by itself
      onCancel={(e) => { e.preventDefault(); closeDialog(); }}
      onPointerDown={(e) => { if (e.target === element.current) closeDialog(); }}
    >
      <div class="modal-inside">
        {bare ? null : (
          <header class="modal-head">
            <h2>{title}</h2>
            <IconButton icon="close" label="Close" onClick={closeDialog} />
          </header>
        )}
        {children}
      </div>
    </dialog>
  );
}

export function DialogButtons({ children }: { children: ComponentChildren }) {
  return <footer class="modal-foot">{children}</footer>;
}
