/** What one measures with: tools are made from the table of kinds. */
import type { IconName } from "../icons";
import type { Measure } from "../protocol";
import { label } from "../values";

/** What the clicks of a tool say: places themselves, corners of a box, a piece, a label; or nothing, all of the volume. */
export type Takes = "points" | "box" | "seed" | "label" | "nothing";

export interface Tool {
  name: string;
  title: string;
  doc: string;
  icon: IconName;
  takes: Takes;
  /** Clicks; without an end, Enter or a double click ends them. */
  least: number;
  most: number;
  /** Which can be measured so; the first by itself. */
  kinds: string[];
}

const ICONS: { [name: string]: IconName } = { point: "point", distance: "distance", polyline: "polyline", angle: "angle", profile: "profile", geodesic: "path" };
const ORDER = ["point", "distance", "polyline", "angle", "profile", "geodesic"];

const OBJECTS: { takes: Exclude<Takes, "points">; title: string; doc: string; icon: IconName; clicks: number; first: string }[] = [
  { takes: "box", title: "Region", doc: "what lies in a box of samples", icon: "region", clicks: 2, first: "statistics" },
  { takes: "seed", title: "Piece", doc: "the connected piece that is clicked", icon: "piece", clicks: 1, first: "summary" },
  { takes: "label", title: "Label", doc: "all that has the label that is clicked", icon: "label", clicks: 1, first: "summary" },
  { takes: "nothing", title: "Whole volume", doc: "all samples of the volume", icon: "volume", clicks: 0, first: "histogram" },
];

/** Kinds of volumes that are told by no points, and of which the property says the part. */
function kindsBy(measures: Measure[], property: string | null, first: string): string[] {
  const fit = measures.filter((row) => row.least_points === 0 &&
    row.forms.some((form) => form.of.includes("volume") && !form.other && !form.uses.includes("points") && (!property || form.uses.includes(property))));
  return fit.map((row) => row.name).sort((a, b) => Number(b === first) - Number(a === first));
}

export function toolsOf(measures: Measure[]): Tool[] {
  const byPoints = measures.filter((row) => row.least_points > 0).flatMap((row): Tool[] => {
    const tool: Tool = { name: row.name, title: label(row.name), doc: row.doc, icon: ICONS[row.name] ?? "measure", takes: "points", least: row.least_points, most: row.least_points, kinds: [row.name] };
    return row.any_points ? [tool, { ...tool, name: "polyline", title: "Polyline", doc: "the length along several points", icon: "polyline", most: Infinity }] : [tool];
  });
  byPoints.sort((a, b) => (ORDER.indexOf(a.name) + 1 || 99) - (ORDER.indexOf(b.name) + 1 || 99));
  const ofObjects = OBJECTS.map(({ takes, title, doc, icon, clicks, first }): Tool => ({
    name: takes, title, doc, icon, takes, least: clicks, most: clicks, kinds: kindsBy(measures, takes === "nothing" ? null : takes, first),
  }));
  return [...byPoints, ...ofObjects.filter((tool) => tool.kinds.length > 0)];
}

/** What to do next, in one sentence. */
export function hintOf(tool: Tool, given: number): string {
  if (tool.takes === "nothing") return "";
  if (tool.takes === "seed" || tool.takes === "label") return `Click on the ${tool.takes === "seed" ? "piece" : "label"} in a slice or in the Navigator. Escape puts the tool away.`;
  const what = tool.takes === "box" ? "corner" : "point";
  const which = ["first", "second", "third"][given] ?? "next";
  const end = given >= tool.least && tool.most > tool.least ? " Enter or a double click ends the line." : "";
  return `Click the ${tool.most === 1 ? what : `${which} ${what}`}, or press Space.${end}${given ? " Backspace takes the last one back, Escape all of them." : " Escape puts the tool away."}`;
}
