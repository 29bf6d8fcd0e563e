/** Where the focus goes when the row that has it goes away: to the same button of the next row, or of the one before. */
export function leaveRow(row: string): void {
  const from = document.activeElement;
  const at = from?.closest(row);
  const next = at?.nextElementSibling ?? at?.previousElementSibling;
  const kind = from?.classList[0];
  if (!next || !kind) return;
  const same = [...at!.querySelectorAll<HTMLElement>(`.${kind}`)].indexOf(from as HTMLElement);
  const buttons = [...next.querySelectorAll<HTMLElement>(`.${kind}`)];
  (buttons[same] ?? buttons[0] ?? next.querySelector<HTMLElement>("button"))?.focus();
}
