/** Dark or light: what was chosen, else what the system prefers; dark where neither says anything. */
import { signal } from "@preact/signals";

export type Theme = "dark" | "light";

const KEY = "volvis-theme";
const prefersLight = matchMedia("(prefers-color-scheme: light)");

function stored(): Theme | null {
  try {
    const value = localStorage.getItem(KEY);
    return value === "dark" || value === "light" ? value : null;
  } catch {
    return null; // storage may be forbidden
  }
}

export const theme = signal<Theme>(stored() ?? (prefersLight.matches ? "light" : "dark"));

export function applyTheme(): void {
  document.documentElement.dataset["theme"] = theme.value;
}

export function toggleTheme(): void {
  theme.value = theme.value === "dark" ? "light" : "dark";
  applyTheme();
  try {
    localStorage.setItem(KEY, theme.value);
  } catch {
    // it then lasts as long as the page
  }
}

prefersLight.addEventListener("change", () => {
  if (stored()) return;
  theme.value = prefersLight.matches ? "light" : "dark";
  applyTheme();
});
