/** Dark or light: what was chosen, else what the system prefers; dark where neither says anything. */
import { signal } from "@preact/signals";
import { keep, kept } from "./storage";

export type Theme = "dark" | "light";

const prefersLight = matchMedia("(prefers-color-scheme: light)");

function stored(): Theme | null {
  const value = kept("theme");
  return value === "dark" || value === "light" ? value : null;
}

export const theme = signal<Theme>(stored() ?? (prefersLight.matches ? "light" : "dark"));

export function applyTheme(): void {
  document.documentElement.dataset["theme"] = theme.value;
}

export function toggleTheme(): void {
  theme.value = theme.value === "dark" ? "light" : "dark";
  applyTheme();
  keep("theme", theme.value);
}

prefersLight.addEventListener("change", () => {
  if (stored()) return;
  theme.value = prefersLight.matches ? "light" : "dark";
  applyTheme();
});
