/** The six sides from which things are cut. */
export type Vec = readonly number[];

const DIRECTIONS: Vec[] = [[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]];

/** After the one that is nearest to a direction. */
export function nextDirection(normal: Vec): Vec {
  const along = DIRECTIONS.map((d) => d.reduce((sum, v, i) => sum + v * (normal[i] ?? 0), 0));
  return DIRECTIONS[(along.indexOf(Math.max(...along)) + 1) % DIRECTIONS.length]!;
}
