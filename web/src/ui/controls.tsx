/** Buttons, switches and fields that all panels are made of. */
import type { ComponentChildren, TargetedKeyboardEvent } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { Icon, type IconName } from "../icons";
import { formatNumber } from "../values";

interface IconButtonProps {
  icon: IconName;
  label: string;
  onClick: () => void;
  disabled?: boolean;
  pressed?: boolean;
  keys?: string;
  class?: string;
}

/** The label is its name for readers and what is shown when the pointer rests. */
export function IconButton({ icon, label, onClick, disabled, pressed, keys, class: extra }: IconButtonProps) {
  return (
    <button
      type="button" class={`icon-button ${extra ?? ""}`} aria-label={label} title={keys ? `${label} (${keys})` : label}
      onClick={onClick} disabled={disabled} aria-pressed={pressed}
    >
      <Icon name={icon} />
    </button>
  );
}

export function Switch({ id, on, onChange, disabled, describedBy }: {
  id?: string; on: boolean; onChange: (on: boolean) => void; disabled?: boolean; describedBy?: string;
}) {
  return (
    <button
      type="button" role="switch" id={id} class="switch" aria-checked={on} disabled={disabled}
      aria-labelledby={id ? `${id}-label` : undefined} aria-describedby={describedBy} onClick={() => onChange(!on)}
    >
      <span class="switch-knob" />
    </button>
  );
}

interface NumberFieldProps {
  id?: string;
  label?: string;
  value: number | string | null; // text: an entry that is refused, left as it was typed
  placeholder?: string;
  unit?: string;
  step?: number;
  disabled?: boolean;
  invalid?: boolean;
  describedBy?: string;
  onCommit: (text: string) => void;
}

/** What is typed and not yet given; another value from elsewhere takes its place. No effect does that: it may come late,
 * when something has been typed already. */
export function useTyped(shown: string): [string | null, (text: string | null) => void] {
  const [typed, setTyped] = useState<{ text: string; over: string } | null>(null);
  return [typed?.over === shown ? typed.text : null, (text) => setTyped(text === null ? null : { text, over: shown })];
}

/** Takes effect on Enter and when it is left; arrows step. What is being typed is not disturbed by what comes in. */
export function NumberField({ id, label, value, placeholder, unit, step, disabled, invalid, describedBy, onCommit }: NumberFieldProps) {
  const shown = value === null ? "" : typeof value === "string" ? value : formatNumber(value, 6);
  const [typed, setTyped] = useTyped(shown);
  const commit = () => {
    if (typed !== null && typed !== shown) onCommit(typed);
    setTyped(null);
  };
  const onKeyDown = (event: TargetedKeyboardEvent<HTMLInputElement>) => {
    if (event.key === "Enter") commit();
    else if (event.key === "Escape" && typed !== null) {
      setTyped(null);
      event.stopPropagation();
      event.preventDefault();
    } else if ((event.key === "ArrowUp" || event.key === "ArrowDown") && step && typeof value === "number") {
      event.preventDefault();
      const by = step * (event.shiftKey ? 10 : 1) * (event.key === "ArrowUp" ? 1 : -1);
      onCommit(String(Number((value + by).toPrecision(12))));
    }
  };
  return (
    <span class={`field ${unit ? "field-unit" : ""}`}>
      <input
        id={id} type="text" inputMode="decimal" autocomplete="off" spellcheck={false} aria-label={label}
        aria-invalid={invalid || undefined} aria-describedby={describedBy} value={typed ?? shown} placeholder={placeholder}
        disabled={disabled} onInput={(e) => setTyped(e.currentTarget.value)} onBlur={commit} onKeyDown={onKeyDown}
      />
      {unit ? <span class="unit" aria-hidden="true">{unit}</span> : null}
    </span>
  );
}

const STILL_MS = 400;

/** live: what is typed takes effect as soon as hands are still, too. */
export function TextField({ id, label, value, placeholder, disabled, invalid, describedBy, live, onCommit }: {
  id?: string; label?: string; value: string; placeholder?: string; disabled?: boolean; invalid?: boolean; describedBy?: string; live?: boolean;
  onCommit: (text: string) => void;
}) {
  const [typed, setTyped] = useTyped(value);
  const timer = useRef(0);
  useEffect(() => () => clearTimeout(timer.current), []);
  const commit = () => {
    clearTimeout(timer.current);
    if (typed !== null && typed !== value) onCommit(typed);
    setTyped(null);
  };
  const type = (text: string) => {
    setTyped(text);
    clearTimeout(timer.current);
    if (live) timer.current = window.setTimeout(() => onCommit(text), STILL_MS);
  };
  return (
    <span class="field">
      <input
        id={id} type="text" autocomplete="off" spellcheck={false} aria-label={label} aria-invalid={invalid || undefined}
        aria-describedby={describedBy} value={typed ?? value} placeholder={placeholder} disabled={disabled}
        onInput={(e) => type(e.currentTarget.value)} onBlur={commit} onKeyDown={(e) => e.key === "Enter" && commit()}
      />
    </span>
  );
}

export function Select({ id, label, value, options, disabled, invalid, describedBy, onChange }: {
  id?: string; label?: string; value: string; options: { value: string; text: string }[]; disabled?: boolean; invalid?: boolean;
  describedBy?: string; onChange: (value: string) => void;
}) {
  return (
    <span class="field field-select">
      <select
        id={id} aria-label={label} value={value} disabled={disabled} aria-invalid={invalid || undefined}
        aria-describedby={describedBy} onChange={(e) => onChange(e.currentTarget.value)}
      >
        {options.map((option) => <option key={option.value} value={option.value}>{option.text}</option>)}
      </select>
      <Icon name="down" />
    </span>
  );
}

/** From 0 to 1; begin and end let a drag be one step for undo. */
export function Slider({ label, share, valueText, disabled, onBegin, onChange, onEnd }: {
  label: string; share: number; valueText: string; disabled?: boolean; onBegin: () => void; onChange: (share: number) => void; onEnd: () => void;
}) {
  const input = useRef<HTMLInputElement>(null);
  const clamped = Math.min(1, Math.max(0, Number.isFinite(share) ? share : 0));
  useEffect(() => input.current?.style.setProperty("--share", String(clamped)));
  return (
    <input
      ref={input} type="range" class="slider" min={0} max={1} step={0.005} value={clamped} aria-label={label} aria-valuetext={valueText}
      disabled={disabled} onPointerDown={onBegin} onKeyDown={onBegin} onInput={(e) => onChange(Number(e.currentTarget.value))} onChange={onEnd}
    />
  );
}

/** A group that folds. */
export function Fold({ id, title, note, open, onToggle, actions, children }: {
  id: string; title: string; note?: string; open: boolean; onToggle: (open: boolean) => void; actions?: ComponentChildren; children: ComponentChildren;
}) {
  return (
    <section class="fold">
      <div class="fold-head">
        <button type="button" class="fold-button" aria-expanded={open} aria-controls={open ? `${id}-body` : undefined} onClick={() => onToggle(!open)}>
          <Icon name={open ? "down" : "right"} />
          <span class="fold-title">{title}</span>
          {note ? <span class="fold-note">{note}</span> : null}
        </button>
        {actions}
      </div>
      {open ? <div class="fold-body" id={`${id}-body`}>{children}</div> : null}
    </section>
  );
}
