/** Pixels of the screen, not of the style sheet: a picture at rest is sharp on every display. */

const SIDE_MOST = 8192;

/** Calls at once, and whenever the element has another size. Returns what ends it. */
export function watchSize(element: HTMLElement, changed: (width: number, height: number) => void): () => void {
  const measure = () => {
    const scale = window.devicePixelRatio || 1;
    const pixels = (length: number) => Math.max(16, Math.min(SIDE_MOST, Math.round(length * scale)));
    changed(pixels(element.clientWidth), pixels(element.clientHeight));
  };
  const observer = new ResizeObserver(measure);
  observer.observe(element);
  measure();
  return () => observer.disconnect();
}
