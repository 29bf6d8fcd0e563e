/** A view that cannot be drawn: what it is about, and why. */
export interface Failure {
  text: string;
  /** The property of the World that it is about, as far as the server knows. */
  where: string | null;
  /** The newest frame from before: one with a greater number is of what can be drawn again. */
  frame: number;
}

/** The dataset that cannot be made. */
export function datasetOf(failure: Failure): string | null {
  return /^datasets\.([^.]+)/.exec(failure.where ?? "")?.[1] ?? null;
}

/** The sentence without the place that it begins with. */
export function reasonOf({ text, where }: Failure): string {
  return where && text.startsWith(`${where}: `) ? text.slice(where.length + 2) : text;
}
