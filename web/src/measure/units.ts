/** How units stand beside numbers: "mm^2" is " mm²", "deg" is "°". */
const POWERS: { [power: string]: string } = { 2: "²", 3: "³" };

export function unitText(unit: string | undefined): string {
  if (!unit) return "";
  if (unit === "deg") return "°";
  return ` ${unit.replace(/\^(\d)$/, (all, power: string) => POWERS[power] ?? all).replace(/^um/, "µm")}`;
}
