/** Colours side by side, as one bar. */
import { useId } from "preact/hooks";

/** Parts of "#rrggbbaa": the colour, and how opaque. */
function parts(color: string): { rgb: string; alpha: number } {
  return { rgb: color.slice(0, 7), alpha: color.length >= 9 ? parseInt(color.slice(7, 9), 16) / 255 : 1 };
}

/** Opaque colours fill the bar; where they are not, their opacity is the height, as in the editor. */
export function ColorBar({ colors, curve }: { colors: string[]; curve?: boolean }) {
  const id = `bar-${useId()}`;
  const n = Math.max(1, colors.length - 1);
  const area = curve
    ? `M0 24${colors.map((color, i) => `L${(100 * i) / n} ${24 - 22 * Math.sqrt(parts(color).alpha)}`).join("")}L100 24z`
    : "M0 0H100V24H0z";
  return (
    <svg class="color-bar" viewBox="0 0 100 24" preserveAspectRatio="none" aria-hidden="true">
      <linearGradient id={id}>
        {colors.map((color, i) => <stop key={i} offset={i / n} stop-color={parts(color).rgb} />)}
      </linearGradient>
      <path d={area} fill={`url(#${id})`} />
    </svg>
  );
}
