/** What one measures with: tools are made from the table of kinds. */
import type { IconName } from "../icons";
import type { Measure } from "../protocol";
import { isFlat, type Drawn } from "./regions";
import { label } from "../values";

/** What the clicks of a tool say: places themselves, a region that is drawn, corners of a box of samples, a piece, a label; or
 * nothing, all of the volume. */
export type Takes = "points" | Drawn | "box" | "seed" | "label" | "nothing";

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

/** property: by which a measurement has it. */
const OBJECTS: { takes: Exclude<Takes, "points">; property: string | null; title: string; doc: string; icon: IconName; clicks: [number, number]; first: string }[] = [
  { takes: "rectangle", property: "region", title: "Rectangle", doc: "what lies in a rectangle, one slice thick", icon: "rectangle", clicks: [2, 2], first: "statistics" },
  { takes: "ellipse", property: "region", title: "Ellipse", doc: "what lies in an ellipse, one slice thick", icon: "ellipse", clicks: [2, 2], first: "statistics" },
  { takes: "polygon", property: "region", title: "Polygon", doc: "what lies in an outline, one slice thick, clicked corner by corner or drawn in one go", icon: "polygon", clicks: [3, Infinity], first: "statistics" },
  { takes: "sphere", property: "region", title: "Sphere", doc: "what lies in a ball: its middle, then its border", icon: "sphere", clicks: [2, 2], first: "statistics" },
  { takes: "box", property: "box", title: "Box", doc: "what lies in a box of samples", icon: "region", clicks: [2, 2], first: "statistics" },
  { takes: "seed", property: "seed", title: "Piece", doc: "the connected piece that is clicked", icon: "piece", clicks: [1, 1], first: "summary" },
  { takes: "label", property: "label", title: "Label", doc: "all that has the label that is clicked", icon: "label", clicks: [1, 1], first: "summary" },
  { takes: "nothing", property: null, title: "Whole volume", doc: "all samples of the volume", icon: "volume", clicks: [0, 0], first: "histogram" },
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
  const ofObjects = OBJECTS.map(({ takes, property, title, doc, icon, clicks: [least, most], first }): Tool => ({
    name: takes, title, doc, icon, takes, least, most, kinds: kindsBy(measures, property, first),
  }));
  return [...byPoints, ...ofObjects.filter((tool) => tool.kinds.length > 0)];
}

/** What is drawn on meshes; each by what a kind of measurement uses for it. */
const ON_MESHES: { [takes in Takes]?: (uses: string[]) => boolean } = {
  points: (uses) => uses.includes("points"),
  nothing: (uses) => !uses.includes("points"),
  rectangle: (uses) => uses.includes("region"),
  polygon: (uses) => uses.includes("region"),
  sphere: (uses) => uses.includes("region"),
};

/** Which of its kinds can be measured where meshes are all that is seen: places on them, what they are as a whole, and what of
 * them is in a region. */
export function kindsOnMeshes(tool: Tool, measures: Measure[]): string[] {
  const fits = ON_MESHES[tool.takes];
  const names = measures.filter((row) => fits && row.forms.some((form) => form.of.includes("shown") && !form.other && fits(form.uses))).map((row) => row.name);
  return tool.kinds.filter((kind) => names.includes(kind));
}

/** What to do next, in one sentence. */
export function hintOf(tool: Tool, given: number, onMeshes = false): string {
  if (tool.takes === "nothing") return "";
  if (tool.takes === "seed" || tool.takes === "label") return `Click on the ${tool.takes === "seed" ? "piece" : "label"} in a slice or in the Navigator. Escape puts the tool away.`;
  const what = tool.takes === "points" ? "point" : "corner";
  const which = ["first", "second", "third"][given] ?? "next";
  const end = given >= tool.least && tool.most > tool.least ? ` Enter or a double click ${tool.takes === "polygon" ? "closes the outline" : "ends the line"}.` : "";
  const next = tool.takes === "sphere" ? (given ? "a place on its border" : "the middle") : tool.most === 1 ? `the ${what}` : `the ${which} ${what}`;
  const flat = onMeshes ? " on the mesh: what lies behind the outline is measured, all the way through" : " in a slice, or in the Navigator to draw in the plane that faces you";
  const where = isFlat(tool.takes) && !given ? flat : "";
  return `Click ${next}${where}, or press Space.${end}${given ? " Backspace takes the last one back, Escape all of them." : " Escape puts the tool away."}`;
}
