/** What the browser keeps for this page. Storage may be forbidden: then it lasts as long as the page. */

const PREFIX = "volvis-";

export function keep(name: string, value: string): void {
  try {
    localStorage.setItem(PREFIX + name, value);
  } catch {
    // forbidden, or full
  }
}

export function kept(name: string): string | null {
  try {
    return localStorage.getItem(PREFIX + name);
  } catch {
    return null;
  }
}
