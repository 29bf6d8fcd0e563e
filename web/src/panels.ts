/** Both panels beside the picture where there is room; on narrow pages they lie over it, one at a time. */
import { leftOpen, rightOpen } from "./store";

const narrow = matchMedia("(max-width: 900px)");

function fit(): void {
  leftOpen.value = rightOpen.value = !narrow.matches;
}

export function watchPanels(): void {
  fit();
  narrow.addEventListener("change", fit);
}

export function togglePanel(side: "left" | "right"): void {
  const [panel, other] = side === "left" ? [leftOpen, rightOpen] : [rightOpen, leftOpen];
  panel.value = !panel.value;
  if (panel.value && narrow.matches) other.value = false;
}

/** More room for the picture, and back. */
export function togglePanels(): void {
  const some = leftOpen.value || rightOpen.value;
  leftOpen.value = !some;
  rightOpen.value = !some && !narrow.matches;
}
